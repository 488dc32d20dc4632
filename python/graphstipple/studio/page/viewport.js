// Where the canvas of the drawing lies on the stage. In: sizes in device pixels, zooms, pans. Out: places, the part that is seen.

const MOST_ZOOM = 64;
const PADDING = 0.03;

/** The part of the canvas that is seen: `scale` device pixels a canvas pixel, `centre` in the middle of each pane. */
export class Viewport {
    constructor() {
        this.stage = [1, 1];
        this.canvas = [1, 1];
        this.sheet = null;
        this.mode = "drawing";
        this.scale = 1;
        this.centre = [0.5, 0.5];
        this.isFitted = true;
    }

    /** The panes of the stage: {what, x, y, width, height} in device pixels. */
    get panes() {
        const [width, height] = this.stage;
        const pane = (what, x, y, right, bottom) => ({ what, x, y, width: right - x, height: bottom - y });
        if (this.mode !== "beside") {
            return [pane(this.mode, 0, 0, width, height)];
        }
        if (width >= height) {
            const half = Math.floor(width / 2);
            return [pane("photo", 0, 0, half, height), pane("drawing", half, 0, width, height)];
        }
        const half = Math.floor(height / 2);
        return [pane("photo", 0, 0, width, half), pane("drawing", 0, half, width, height)];
    }

    /** The pane whose part of the drawing is asked for: panes are of one size, to a pixel. */
    get mainPane() {
        return this.panes.at(-1);
    }

    /** The sheet around the canvas, or the canvas: left, top, right, bottom in canvas pixels. */
    get box() {
        const [width, height] = this.canvas;
        if (!this.sheet) {
            return [0, 0, width, height];
        }
        const perUnit = width / this.sheet.drawing[0];
        const [x, y] = [(this.sheet.page[0] * perUnit - width) / 2, (this.sheet.page[1] * perUnit - height) / 2];
        return [-x, -y, width + x, height + y];
    }

    /** The scale at which everything is seen. */
    get fittingScale() {
        const pane = this.mainPane;
        const [left, top, right, bottom] = this.box;
        const scale = (1 - 2 * PADDING) * Math.min(pane.width / (right - left), pane.height / (bottom - top));
        return Math.max(1, Math.floor(scale * this.canvas[0])) / this.canvas[0];
    }

    /** Where the canvas's corner lies in a pane, on whole device pixels, so that drawings are shown pixel by pixel. */
    origin(pane) {
        return [
            Math.round(pane.x + pane.width / 2 - this.centre[0] * this.scale),
            Math.round(pane.y + pane.height / 2 - this.centre[1] * this.scale),
        ];
    }

    /** What of the canvas is seen: {part, columns}, or null if nothing is. */
    get seen() {
        const pane = this.mainPane;
        const [x, y] = this.origin(pane);
        const [width, height] = this.canvas;
        const left = Math.max(0, (pane.x - x) / this.scale);
        const top = Math.max(0, (pane.y - y) / this.scale);
        const right = Math.min(width, (pane.x + pane.width - x) / this.scale);
        const bottom = Math.min(height, (pane.y + pane.height - y) / this.scale);
        const columns = Math.round((right - left) * this.scale);
        return right > left && bottom > top ? { part: [left, top, right, bottom], columns: Math.max(1, columns) } : null;
    }

    /** The pane at a place of the stage. */
    paneAt(x, y) {
        return this.panes.find((pane) => x < pane.x + pane.width && y < pane.y + pane.height) ?? this.mainPane;
    }

    /** The place on the canvas, as fractions of its width and height, that a place of the stage shows. */
    fractionAt(x, y) {
        const origin = this.origin(this.paneAt(x, y));
        return [(x - origin[0]) / this.scale / this.canvas[0], (y - origin[1]) / this.scale / this.canvas[1]];
    }

    /** Shows everything. */
    fit() {
        this.isFitted = true;
        this.scale = this.fittingScale;
        this.centre = [this.canvas[0] / 2, this.canvas[1] / 2];
    }

    /** Fits again, if everything was to be seen: after the size, the sheet or the panes have changed. */
    refit() {
        if (this.isFitted) {
            this.fit();
        } else {
            this.clamp();
        }
    }

    /** Zooms to a scale; the place (x, y) of the stage stays where it is, without one the middle. */
    zoomTo(scale, x = null, y = null) {
        const pane = x === null ? this.mainPane : this.paneAt(x, y);
        const [dx, dy] = x === null ? [0, 0] : [x - pane.x - pane.width / 2, y - pane.y - pane.height / 2];
        const fitting = this.fittingScale;
        const next = Math.min(Math.max(MOST_ZOOM, fitting), Math.max(Math.min(1, fitting) / 4, scale));
        this.centre = [this.centre[0] + dx / this.scale - dx / next, this.centre[1] + dy / this.scale - dy / next];
        this.scale = next;
        this.isFitted = false;
        this.clamp();
    }

    /** Moves what is seen by device pixels. */
    pan(dx, dy) {
        this.centre = [this.centre[0] - dx / this.scale, this.centre[1] - dy / this.scale];
        this.isFitted = false;
        this.clamp();
    }

    /** Keeps the middle of each pane inside of what there is to see. */
    clamp() {
        const [left, top, right, bottom] = this.box;
        this.centre = [Math.min(right, Math.max(left, this.centre[0])), Math.min(bottom, Math.max(top, this.centre[1]))];
    }
}
