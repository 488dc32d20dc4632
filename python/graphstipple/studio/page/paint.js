// The painted map of importance. In: strokes as data. Out: grey values, a picture of them, and their colours as an overlay.

const NEUTRAL = 128;
const LONGEST = 1024;
const SOFT = 0.45;
const TARGETS = { more: 255, less: 0, erase: NEUTRAL };
const MORE = [232, 108, 0];
const LESS = [20, 90, 215];
const OPACITY = 150;

/**
 * A map of a photo's proportions. A stroke is {kind, size, strength, points}: size as a fraction of the photo's longest side,
 * points [x, y, pressure] as fractions of its width and height.
 */
export class PaintedMap {
    constructor(width, height) {
        const scale = Math.min(1, LONGEST / Math.max(width, height));
        this.width = Math.max(1, Math.round(width * scale));
        this.height = Math.max(1, Math.round(height * scale));
        const pixels = this.width * this.height;
        this.done = { strokes: [], grey: new Uint8Array(pixels).fill(NEUTRAL) };
        this.live = { stroke: null, points: 0, mask: new Uint8Array(pixels), grey: new Uint8Array(pixels) };
    }

    /** The grey values of strokes; those that were there the last time are not painted again. */
    grey(strokes) {
        if (!this.done.strokes.every((stroke, at) => stroke === strokes[at])) {
            this.done = { strokes: [], grey: this.done.grey.fill(NEUTRAL) };
        }
        for (const stroke of strokes.slice(this.done.strokes.length)) {
            this.done.grey.set(this.greyWith(stroke));
            this.live.stroke = null;
        }
        this.done.strokes = strokes;
        return this.done.grey;
    }

    /** The grey values of what is done with one more stroke, to which points may still be added. */
    greyWith(stroke) {
        const { live } = this;
        if (live.stroke !== stroke || live.points > stroke.points.length) {
            Object.assign(live, { stroke, points: 0 });
            live.mask.fill(0);
            live.grey.set(this.done.grey);
        }
        for (; live.points < stroke.points.length; live.points += 1) {
            this.segment(stroke, Math.max(0, live.points - 1), live.points);
        }
        return live.grey;
    }

    /** Paints one piece of a stroke, the pixels near the line between two of its points. */
    segment(stroke, from, to) {
        const { width, height, live, done } = this;
        const [x0, y0] = [stroke.points[from][0] * width, stroke.points[from][1] * height];
        const [x1, y1] = [stroke.points[to][0] * width, stroke.points[to][1] * height];
        const radius = Math.max(0.5, stroke.size * Math.max(width, height) / 2);
        const pressure = stroke.points[to][2] ?? 1;
        const target = TARGETS[stroke.kind];
        const length = (x1 - x0) ** 2 + (y1 - y0) ** 2;
        const [left, right] = reach(x0, x1, radius, width);
        const [top, bottom] = reach(y0, y1, radius, height);
        for (let y = top; y < bottom; y += 1) {
            for (let x = left; x < right; x += 1) {
                const [dx, dy] = [x + 0.5 - x0, y + 0.5 - y0];
                const along = length > 0 ? Math.min(1, Math.max(0, (dx * (x1 - x0) + dy * (y1 - y0)) / length)) : 0;
                const distance = Math.hypot(dx - along * (x1 - x0), dy - along * (y1 - y0)) / radius;
                if (distance < 1) {
                    const edge = Math.min(1, (1 - distance) / SOFT);
                    const cover = Math.round(255 * pressure * edge * edge * (3 - 2 * edge));
                    const at = y * width + x;
                    if (cover > live.mask[at]) {
                        live.mask[at] = cover;
                        live.grey[at] = Math.round(done.grey[at] + (target - done.grey[at]) * stroke.strength * cover / 255);
                    }
                }
            }
        }
    }

    /** The map as a PNG. */
    blob(strokes) {
        const canvas = pixelsOf(this.grey(strokes), this.width, this.height, greyOpaque);
        return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
    }

    /** The map in colours, with a stroke that is being painted. */
    overlay(strokes, stroke = null, canvas = null) {
        const grey = this.grey(strokes);
        return pixelsOf(stroke ? this.greyWith(stroke) : grey, this.width, this.height, colorOfPainted, canvas);
    }
}

/** The pixels of an axis that a piece of a stroke may reach: the first, and the one after the last. */
function reach(from, to, radius, length) {
    return [Math.max(0, Math.floor(Math.min(from, to) - radius)), Math.min(length, Math.ceil(Math.max(from, to) + radius))];
}

/** A grey value as a pixel. */
function greyOpaque(value) {
    return (0xff000000 | (value << 16) | (value << 8) | value) >>> 0;
}

/** A picture of grey values, each coloured by a function: 0xAABBGGRR. */
function pixelsOf(grey, width, height, colorOf, reused = null) {
    const canvas = reused ?? document.createElement("canvas");
    if (canvas.width !== width || canvas.height !== height) {
        [canvas.width, canvas.height] = [width, height];
    }
    const table = Uint32Array.from({ length: 256 }, (_, value) => colorOf(value));
    const pixels = new ImageData(width, height);
    const colors = new Uint32Array(pixels.data.buffer);
    for (let at = 0; at < grey.length; at += 1) {
        colors[at] = table[grey[at]];
    }
    canvas.getContext("2d").putImageData(pixels, 0, 0);
    return canvas;
}

/** The colour of a painted value: orange above the neutral grey, blue below it, clear at it. */
function colorOfPainted(value) {
    const [red, green, blue] = value > NEUTRAL ? MORE : LESS;
    const alpha = Math.round(OPACITY * Math.abs(value - NEUTRAL) / (value > NEUTRAL ? 127 : 128));
    return ((alpha << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

/** The saliency in colours: the more of it, the more orange. */
export function saliencyOverlay(bitmap) {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const grey = Uint8Array.from({ length: data.length / 4 }, (_, at) => data[at * 4]);
    const [red, green, blue] = MORE;
    const colorOf = (value) => (((OPACITY * value / 255) << 24) | (blue << 16) | (green << 8) | red) >>> 0;
    return pixelsOf(grey, bitmap.width, bitmap.height, colorOf);
}
