// The stage: photo, drawing, sheet and overlay, painted into one canvas. In: pictures and a view. Out: calls when that changes.

import { make } from "./elements.js";
import { listenForGestures } from "./gestures.js";
import { Pictures } from "./pictures.js";
import { Viewport } from "./viewport.js";
import { wipeHandle } from "./wipe.js";

const KEY_PAN = 60;
const KEY_ZOOM = 1.25;

/** The stage; `onview()`, `onzoom(scale)`, `brush()` and `onkey(event)` come from who makes it. */
export class Stage {
    constructor({ onview, onzoom, brush, onkey, signal }) {
        this.viewport = new Viewport();
        this.pictures = new Pictures();
        this.photo = null;
        this.overlay = null;
        this.paper = "#ffffff";
        this.calls = { onview, onzoom, brush, onkey };
        this.frame = 0;
        this.wipe = wipeHandle(() => this.paint());
        this.canvas = make("canvas", { role: "img", "aria-label": "The drawing" });
        this.brushMark = make("div", { class: "gs-brush", hidden: true });
        const about = "The drawing. Plus and minus zoom, 0 fits, 1 shows it pixel by pixel, arrow keys move it.";
        const attributes = { class: "gs-stage", tabindex: "0", role: "application", "aria-label": about };
        this.element = make("div", attributes, this.canvas, this.brushMark, this.wipe.element);
        this.context = this.canvas.getContext("2d");
        this.element.addEventListener("keydown", (event) => this.key(event), { signal });
        const act = {
            pixelRatio: () => this.pixelRatio,
            zoomBy: (factor, x, y) => this.move(() => this.viewport.zoomTo(this.viewport.scale * factor, x, y)),
            pan: (dx, dy) => this.move(() => this.viewport.pan(dx, dy)),
            brush: () => (this.photo ? brush() : null),
        };
        listenForGestures(this.element, act, signal);
        this.observe(signal);
    }

    get pixelRatio() {
        return this.canvas.width / Math.max(1, this.element.clientWidth);
    }

    /** Keeps the canvas as large as the stage, in device pixels. */
    observe(signal) {
        const observer = new ResizeObserver((entries) => {
            const exact = entries.at(-1).devicePixelContentBoxSize?.[0];
            const ratio = window.devicePixelRatio;
            const width = devicePixels(this.element.clientWidth * ratio, exact?.inlineSize);
            const height = devicePixels(this.element.clientHeight * ratio, exact?.blockSize);
            this.resize(width, height);
        });
        try {
            observer.observe(this.element, { box: "device-pixel-content-box" });
        } catch {
            observer.observe(this.element);
        }
        signal.addEventListener("abort", () => observer.disconnect());
    }

    resize(width, height) {
        if (this.canvas.width !== width || this.canvas.height !== height) {
            [this.canvas.width, this.canvas.height] = [width, height];
            this.viewport.stage = [width, height];
            this.viewport.refit();
            this.paint();
            this.changed();
        }
    }

    /** Shows a photo; the drawing of the one before is gone unless it is the same one again. */
    setPhoto(bitmap, width, height, isSame) {
        this.photo?.close();
        this.photo = bitmap;
        if (!isSame) {
            this.pictures.clear();
            this.viewport.canvas = [width, height];
            this.viewport.sheet = null;
            this.viewport.fit();
        }
        this.paint();
        this.changed();
    }

    /** Shows a picture of the drawing; false if a better one is there. */
    setPicture(picture) {
        const isTaken = this.pictures.add(picture);
        this.paint();
        return isTaken;
    }

    setSheet(sheet, paper) {
        const isSame = JSON.stringify(sheet) === JSON.stringify(this.viewport.sheet);
        this.paper = paper;
        if (!isSame) {
            this.viewport.sheet = sheet;
            this.move(() => this.viewport.refit());
        }
    }

    setMode(mode) {
        this.wipe.element.hidden = mode !== "wipe" || !this.photo;
        if (mode !== this.viewport.mode) {
            this.viewport.mode = mode;
            this.move(() => this.viewport.refit());
        }
    }

    setOverlay(overlay) {
        if (overlay || this.overlay) {
            this.overlay = overlay;
            this.repaintSoon();
        }
    }

    /** Shows the brush at a fraction of the canvas, `size` as a fraction of its longest side; null hides it. */
    setBrush(at, size) {
        this.brushMark.hidden = at === null;
        if (at !== null) {
            const { viewport, pixelRatio } = this;
            const origin = viewport.origin(at.pane ?? viewport.mainPane);
            const diameter = Math.max(...viewport.canvas) * size * viewport.scale / pixelRatio;
            const corner = [0, 1].map((axis) => {
                const middle = origin[axis] + at.point[axis] * viewport.canvas[axis] * viewport.scale;
                return `${middle / pixelRatio - diameter / 2}px`;
            });
            Object.assign(this.brushMark.style, { width: `${diameter}px`, height: `${diameter}px`, translate: corner.join(" ") });
        }
    }

    fit() {
        this.move(() => this.viewport.fit());
    }

    oneToOne() {
        this.move(() => this.viewport.zoomTo(1));
    }

    zoomIn() {
        this.move(() => this.viewport.zoomTo(this.viewport.scale * KEY_ZOOM));
    }

    zoomOut() {
        this.move(() => this.viewport.zoomTo(this.viewport.scale / KEY_ZOOM));
    }

    /** Pans so that a fraction of the canvas is inside of the stage. */
    reveal(point) {
        const pane = this.viewport.mainPane;
        const origin = this.viewport.origin(pane);
        const sides = [[pane.x, pane.width], [pane.y, pane.height]];
        const [dx, dy] = sides.map(([start, length], axis) => {
            const at = origin[axis] + point[axis] * this.viewport.canvas[axis] * this.viewport.scale;
            return Math.max(0, start - at) - Math.max(0, at - start - length);
        });
        if (dx !== 0 || dy !== 0) {
            this.move(() => this.viewport.pan(dx, dy));
        }
    }

    key(event) {
        if (event.ctrlKey || event.metaKey || event.altKey || event.target !== this.element || !this.photo) {
            return;
        }
        const step = KEY_PAN * this.pixelRatio * (event.shiftKey ? 4 : 1);
        const pan = (dx, dy) => this.move(() => this.viewport.pan(dx * step, dy * step));
        const actions = {
            "+": () => this.zoomIn(),
            "=": () => this.zoomIn(),
            "-": () => this.zoomOut(),
            0: () => this.fit(),
            1: () => this.oneToOne(),
            ArrowLeft: () => pan(1, 0),
            ArrowRight: () => pan(-1, 0),
            ArrowUp: () => pan(0, 1),
            ArrowDown: () => pan(0, -1),
        };
        if (this.calls.onkey(event)) {
            event.preventDefault();
        } else if (event.key in actions) {
            event.preventDefault();
            actions[event.key]();
        }
    }

    /** Changes the view, and shows it in the next frame. */
    move(change) {
        change();
        this.repaintSoon();
        this.changed();
    }

    changed() {
        if (this.photo) {
            this.calls.onzoom(this.viewport.scale);
            this.calls.onview();
        }
    }

    repaintSoon() {
        this.frame ||= requestAnimationFrame(() => this.paint());
    }

    paint() {
        cancelAnimationFrame(this.frame);
        this.frame = 0;
        const { context, canvas } = this;
        context.clearRect(0, 0, canvas.width, canvas.height);
        if (this.photo) {
            const { panes } = this.viewport;
            panes.forEach((pane) => this.paintPane(pane));
            panes.slice(1).forEach((pane) => this.paintSeam(pane));
        }
    }

    /** A thin line where a pane begins. */
    paintSeam({ x, y, width, height }) {
        this.context.fillStyle = "rgba(128, 124, 116, 0.6)";
        this.context.fillRect(x, y, x > 0 ? 1 : width, x > 0 ? height : 1);
    }

    paintPane(pane) {
        const { context, viewport } = this;
        context.save();
        clip(context, pane.x, pane.y, pane.width, pane.height);
        this.paintSheet(pane);
        if (pane.what === "wipe") {
            const split = Math.round(pane.width * this.wipe.share);
            this.paintClipped(pane, 0, split, () => this.paintPhoto(pane, 1));
            this.paintClipped(pane, split, pane.width, () => this.paintDrawing(pane));
        } else if (pane.what === "photo") {
            this.paintPhoto(pane, 1);
        } else {
            this.paintDrawing(pane);
        }
        if (this.overlay) {
            const [x, y] = viewport.origin(pane);
            context.drawImage(this.overlay, x, y, viewport.canvas[0] * viewport.scale, viewport.canvas[1] * viewport.scale);
        }
        context.restore();
    }

    paintClipped(pane, from, to, paint) {
        if (to > from) {
            this.context.save();
            clip(this.context, pane.x + from, pane.y, to - from, pane.height);
            paint();
            this.context.restore();
        }
    }

    /** The sheet, or the canvas as its own sheet, with an edge around it. */
    paintSheet(pane) {
        const { context, viewport } = this;
        const [x, y] = viewport.origin(pane);
        const place = (side, at) => Math.round([x, y][at % 2] + side * viewport.scale);
        const [left, top, right, bottom] = viewport.box.map(place);
        context.fillStyle = "#ffffff";
        if (viewport.sheet) {
            // A colour that canvases do not know leaves the white.
            context.fillStyle = this.paper;
        }
        context.fillRect(left, top, right - left, bottom - top);
        context.strokeStyle = "rgba(128, 124, 116, 0.6)";
        context.lineWidth = 1;
        context.strokeRect(left - 0.5, top - 0.5, right - left + 1, bottom - top + 1);
    }

    paintPhoto(pane, strength) {
        const { context, viewport } = this;
        const [x, y] = viewport.origin(pane);
        context.globalAlpha = strength;
        context.imageSmoothingQuality = viewport.scale < 0.75 ? "medium" : "low";
        context.drawImage(this.photo, x, y, viewport.canvas[0] * viewport.scale, viewport.canvas[1] * viewport.scale);
        context.globalAlpha = 1;
    }

    /** The drawing, pixel by pixel if it came for this view; until the first picture comes, the photo faintly. */
    paintDrawing(pane) {
        const { context, viewport } = this;
        if (this.pictures.list.length === 0) {
            this.paintPhoto(pane, 0.3);
        }
        const [x, y] = viewport.origin(pane);
        for (const { bitmap, part } of this.pictures.list) {
            const [left, top, right, bottom] = part.map((side) => side * viewport.scale);
            const width = Math.abs(right - left - bitmap.width) < 1.01 ? bitmap.width : right - left;
            const height = Math.abs(bottom - top - bitmap.height) < 1.01 ? bitmap.height : bottom - top;
            const isExact = width === bitmap.width && height === bitmap.height;
            const snapped = (value) => (isExact ? Math.round(value) : value);
            context.imageSmoothingQuality = "medium";
            context.drawImage(bitmap, snapped(x + left), snapped(y + top), width, height);
        }
    }

    /** Lets go of what the browser would keep. */
    close() {
        cancelAnimationFrame(this.frame);
        this.pictures.clear();
        this.photo?.close();
        this.photo = null;
    }
}

/** Whole device pixels of a length: as the browser counts them, unless it counts others (as some do that emulate a screen). */
function devicePixels(length, exact) {
    return Math.max(1, Math.abs(exact - length) < 1 ? exact : Math.round(length));
}

/** Lets what follows be painted inside of a rectangle alone. */
function clip(context, x, y, width, height) {
    context.beginPath();
    context.rect(x, y, width, height);
    context.clip();
}
