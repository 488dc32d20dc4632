// The studio. In: an element and a transport. Out: the studio in the element, and a function that takes it away again.

import { button, iconButton, make, messagePlace, radioGroup } from "./elements.js";
import { lookToText, textToLook } from "./address.js";
import { optionsSection } from "./controls.js";
import { countsLine, progressLine } from "./counts.js";
import { importanceSection } from "./importance.js";
import { keysHelp } from "./keys.js";
import { freshLook, isSameLook, lookBook, tellable, withOption, withSetting } from "./look.js";
import { outputPart, saveFile } from "./output.js";
import { PaintedMap, saliencyOverlay } from "./paint.js";
import { paperSection } from "./paper.js";
import { presetsSection } from "./presets.js";
import { rulesOf } from "./rules.js";
import { Stage } from "./stage.js";
import { Steps } from "./steps.js";
import { fileSize } from "./words.js";

const STORED_STROKES = "graphstipple-strokes";
const ADDRESS_MS = 250;
const PATIENCE_FOR_PHOTO_MS = 3000;
const VIEWS = [["drawing", "Drawing"], ["wipe", "Wipe"], ["beside", "Beside"], ["photo", "Photo"]];
const KEY_BRUSH = 0.01;
const WELCOME = "Drop a photo here: graphstipple turns it into a black-and-white vector drawing of dots and shapes.";

/** Puts the studio into an element; returns what takes it away. */
export function mount(root, transport) {
    const studio = new Studio(root, transport);
    return () => studio.close();
}

/** What a studio knows: the desk's book of looks, the photo, the state with its steps, and what was sent and shown. */
class Studio {
    constructor(root, transport) {
        this.root = root;
        this.transport = transport;
        this.ending = new AbortController();
        this.book = null;
        this.builtOf = "";
        this.limits = { upload: Infinity, nodes: 1e6 };
        this.photo = null;
        this.source = null;
        this.isReopening = false;
        this.state = { look: null, strokes: [], before: "saliency" };
        this.steps = null;
        this.sent = 0;
        this.drawn = null;
        this.isMoving = false;
        this.isFrameTaken = false;
        this.isWaiting = false;
        this.map = null;
        this.uploaded = null;
        this.isUploading = false;
        this.saved = null;
        this.stroke = null;
        this.brushAt = null;
        this.saliency = null;
        this.isSaliencyAsked = false;
        this.arrived = 0;
        this.painted = 0;
        this.epoch = 0;
        this.view = { told: "", isTaken: false };
        this.addressTimer = 0;
        this.keptAt = -Infinity;
        this.missingTimer = 0;
        this.overlayOf = null;
        this.build();
        transport.onmessage = (message, bytes) => this.receive(message, bytes);
        transport.onstate = (state, sentence) => this.connection(state, sentence);
    }

    // What is always there

    build() {
        const { signal } = this.ending;
        const { root, transport } = this;
        root.classList.add("graphstipple-studio");
        root.classList.toggle("gs-page", transport.keepsAddress);
        this.banner = messagePlace();
        this.photoMessage = messagePlace();
        this.counts = countsLine();
        this.progress = progressLine();
        this.output = outputPart(() => this.save());
        this.stage = new Stage({
            onview: () => this.sees(),
            onzoom: (scale) => this.showZoom(scale),
            brush: () => this.brush(),
            onkey: (event) => this.brushKey(event),
            signal,
        });
        this.empty = this.emptyState();
        this.stage.element.append(this.empty, this.progress.element);
        this.panel = make("section", { class: "gs-panel", "aria-label": "Settings of the drawing" });
        this.frame = make("div", { class: "gs-frame" }, this.header(), this.banner.element, this.stageSection(), this.panel);
        root.replaceChildren(this.frame);
        this.setMode("drawing");
        this.listen(signal);
    }

    header() {
        this.file = make("input", { type: "file", accept: "image/*,.tif,.tiff", hidden: true, "aria-label": "Photo" });
        this.file.addEventListener("change", () => {
            this.open(this.file.files[0]);
            this.file.value = "";
        });
        const rest = make("span", { class: "gs-title-rest", text: " studio" });
        this.title = make(this.transport.keepsAddress ? "h1" : "h2", { class: "gs-title" }, "graphstipple", rest);
        this.name = make("span", { class: "gs-name" });
        this.undo = iconButton("undo", "Undo", "undo", () => this.go(-1), { disabled: true });
        this.redo = iconButton("redo", "Redo", "redo", () => this.go(1), { disabled: true });
        const keys = keysHelp();
        const choose = button("Open photo", "open", () => this.file.click());
        const buttons = make("div", { class: "gs-buttons" }, choose, this.file, this.undo, this.redo, keys.button);
        return make("header", { class: "gs-header" }, this.title, this.name, buttons, keys.dialog);
    }

    emptyState() {
        const example = button("Try an example", "example", () => this.openExample());
        const choose = button("Choose a photo", null, () => this.file.click(), { class: "gs-button gs-primary" });
        this.emptyWords = make("p", { text: "Connecting …" });
        this.emptyButtons = make("div", { class: "gs-buttons", hidden: true }, choose, example);
        return make("div", { class: "gs-empty" }, this.emptyWords, this.emptyButtons);
    }

    stageSection() {
        const attributes = (value) => ({ class: "gs-button", "data-view": value });
        const items = VIEWS.map(([value, label]) => ({ value, content: [label], attributes: attributes(value) }));
        this.views = radioGroup("View", "gs-buttons gs-segments", items, (mode) => this.setMode(mode));
        this.zoom = make("span", { class: "gs-zoom", title: "Zoom", text: "– %" });
        const zooms = make(
            "div",
            { class: "gs-buttons gs-zooms" },
            iconButton("minus", "Zoom out", "zoom-out", () => this.stage.zoomOut()),
            this.zoom,
            iconButton("plus", "Zoom in", "zoom-in", () => this.stage.zoomIn()),
            button("Fit", "fit", () => this.stage.fit()),
            button("1:1", "one-to-one", () => this.stage.oneToOne(), { title: "One pixel of the photo to one of the screen" }),
        );
        const tools = make("div", { class: "gs-tools" }, this.views.element, zooms);
        const foot = make("div", { class: "gs-foot" }, ...this.counts.elements, this.progress.words);
        const work = { class: "gs-work", "aria-label": "Photo and drawing" };
        return make("section", work, tools, this.photoMessage.element, this.stage.element, foot);
    }

    /** Keys, drops and pastes: of the whole page, or in a notebook of the studio alone. */
    listen(signal) {
        const scope = this.transport.keepsAddress ? document : this.root;
        const on = (name, listener) => scope.addEventListener(name, listener, { signal });
        on("keydown", (event) => this.key(event));
        on("input", ({ target }) => target.type === "text" && this.root.contains(target) && (target.dataset.typing = "true"));
        on("change", ({ target }) => delete target.dataset.typing);
        on("dragover", (event) => this.dragged(event, true));
        on("dragleave", (event) => {
            if (!event.relatedTarget) {
                this.root.classList.remove("gs-is-dropping");
            }
        });
        on("drop", (event) => this.dragged(event, false));
        on("paste", (event) => {
            const file = [...(event.clipboardData?.files ?? [])].find((each) => each.type.startsWith("image/"));
            if (file) {
                event.preventDefault();
                this.open(file);
            }
        });
        if (this.transport.keepsAddress) {
            window.addEventListener("hashchange", () => this.addressChanged(), { signal });
            window.addEventListener("pagehide", () => this.steps && this.keepNow(), { signal });
        }
    }

    dragged(event, isOver) {
        if (!event.dataTransfer?.types.includes("Files")) {
            return;
        }
        event.preventDefault();
        this.root.classList.toggle("gs-is-dropping", isOver);
        if (!isOver && event.dataTransfer.files.length > 0) {
            this.open(event.dataTransfer.files[0]);
        }
    }

    key(event) {
        if (!this.transport.keepsAddress) {
            // Keys of the studio are none of the notebook's.
            event.stopPropagation();
        }
        const isCommand = (event.ctrlKey || event.metaKey) && !event.altKey;
        const key = event.key.toLowerCase();
        const by = isCommand && key === "z" ? (event.shiftKey ? 1 : -1) : isCommand && key === "y" ? 1 : 0;
        if (by !== 0 && !isBeingTyped(event.target)) {
            event.preventDefault();
            this.go(by);
        } else if (event.key === "Escape" && this.importance?.tools.kind && !this.root.querySelector("dialog[open]")) {
            this.importance.setBrush(null);
        }
    }

    // Messages of the desk

    receive(message, bytes) {
        const takers = {
            ready: () => this.ready(message),
            photo: () => this.photoCame(message, bytes),
            preset: () => this.presets?.show(message.name, bytes),
            picture: () => this.pictureCame(message, bytes),
            drawn: () => this.drawnCame(message),
            size: () => this.sizeCame(message),
            progress: () => message.id === this.sent && this.progress.set(message.stage, message.fraction),
            file: () => this.fileCame(message, bytes),
            map: () => this.mapCame(bytes),
            refused: () => this.refused(message),
        };
        takers[message.type]?.();
    }

    connection(state, sentence) {
        this.root.dataset.state = state;
        this.banner.show(state === "open" ? "" : sentence);
        if (state !== "open") {
            this.progress.end();
            this.saving(false);
        }
        if (state !== "open" && !this.book) {
            this.emptyWords.textContent = "";
        }
    }

    /** The desk is there, for the first time or again. */
    ready(message) {
        const isFirst = this.book === null;
        this.limits = message.limits;
        const { version, schema, settings, formats, sources, presets } = message;
        const of = JSON.stringify([version, schema, settings, formats, sources, presets]);
        if (of !== this.builtOf) {
            this.builtOf = of;
            this.book = lookBook(message, rulesOf(message.schema));
            this.buildPanel(message);
        }
        if (isFirst) {
            const look = this.transport.keepsAddress ? textToLook(this.book, location.hash) : freshLook(this.book);
            this.state = { look, strokes: [], before: "saliency" };
            this.steps = new Steps(this.state, isSameState);
        }
        this.root.dataset.state = "open";
        this.banner.show("");
        this.emptyWords.textContent = WELCOME;
        this.emptyButtons.hidden = false;
        this.refresh();
        this.view.told = "";
        if (this.source && (message.fresh || !message.photo)) {
            this.isReopening = this.photo !== null;
            this.source.open();
        } else if (message.photo === null && this.photo) {
            const missing = "The studio was started anew, without this photo: please open it again.";
            this.missingTimer = setTimeout(() => this.photoMessage.show(missing), PATIENCE_FOR_PHOTO_MS);
        }
    }

    buildPanel(ready) {
        const { book } = this;
        this.presets = presetsSection(ready.presets, (preset) => this.setLook({ ...this.state.look, preset, options: {} }, false));
        this.options = optionsSection(book, ready.limits.nodes, {
            change: (name, value, moving) => this.setLook(withOption(book, this.state.look, name, value), moving),
            setAllBack: () => this.setLook({ ...this.state.look, options: {} }, false),
            counted: (name) => this.drawn?.stats[name],
        });
        this.importance = importanceSection(ready.sources, {
            choose: (importance, moving) => this.setLook({ ...this.state.look, importance }, moving),
            brush: (kind) => this.brushChosen(kind),
            brushChanged: () => this.showBrush(),
            overlay: () => this.showOverlay(),
            clear: () => this.setStrokes([]),
            download: () => this.downloadMap(),
        });
        this.paper = paperSection(book, {
            setFormat: (suffix) => this.setLook({ ...this.state.look, suffix }, false),
            setSetting: (name, value, moving) => this.setLook(withSetting(this.state.look, name, value), moving === true),
            setMinDot: (value) => this.setLook({ ...this.state.look, min_dot: value }, false),
        });
        const sections = [this.presets, this.options, this.importance, this.paper].map((part) => part.element);
        this.panel.replaceChildren(make("div", { class: "gs-sections" }, ...sections), this.output.element);
    }

    /** A photo is open: shown at once, and drawn with the present look. */
    async photoCame({ name, width, height, mime }, bytes) {
        const hasSize = this.photo?.width === width && this.photo?.height === height;
        const isSame = hasSize && this.photo.name === name;
        if (this.isReopening && !hasSize) {
            return;
        }
        const epoch = isSame ? this.epoch : (this.epoch += 1);
        clearTimeout(this.missingTimer);
        if (!isSame) {
            // Now, as small drawings of this photo may come while it is decoded.
            this.presets.clear();
        }
        // A photo that the desk reads and the browser does not is drawn all the same.
        const blank = () => createImageBitmap(new ImageData(1, 1));
        const bitmap = await createImageBitmap(new Blob([bytes], { type: mime })).catch(blank);
        if (epoch !== this.epoch || this.ending.signal.aborted) {
            bitmap.close();
            return;
        }
        this.isReopening = false;
        const isFirst = this.photo === null;
        this.photo = { name, width, height };
        this.empty.hidden = true;
        this.showName(name);
        this.stage.canvas.setAttribute("aria-label", `The drawing of ${name}`);
        this.photoMessage.show("");
        if (this.transport.keepsAddress) {
            document.title = `${name} – graphstipple studio`;
        }
        this.uploaded = null;
        this.saliency = null;
        this.isSaliencyAsked = false;
        if (!isSame) {
            this.newPhoto(isFirst);
        }
        this.stage.setPhoto(bitmap, width, height, isSame);
        this.setMode(this.stage.viewport.mode);
        this.stage.element.classList.add("gs-has-photo");
        this.refresh();
        this.view.told = "";
        this.sendView();
        this.rest();
    }

    /** What belongs to the photo before is gone: strokes, overlay, small pictures, counts. */
    newPhoto(isFirst) {
        this.map = new PaintedMap(this.photo.width, this.photo.height);
        this.saved = null;
        this.drawn = null;
        this.counts.clear();
        this.output.setTexts(null);
        this.paper.showSheet(null);
        const stored = isFirst ? this.storedStrokes() : null;
        const withoutStrokes = (state) => {
            const importance = state.look.importance === "painted" ? state.before : state.look.importance;
            return { ...state, strokes: [], look: { ...state.look, importance } };
        };
        if (stored) {
            this.state = { ...this.state, ...stored };
            this.steps.rewrite((state) => ({ ...state, ...stored }));
        } else {
            this.state = withoutStrokes(this.state);
            this.steps.rewrite(withoutStrokes);
        }
        this.showOverlay();
    }

    /** Decodes a picture and paints it at once, unless a later one was quicker. */
    async pictureCame(message, bytes) {
        const { epoch } = this;
        const order = (this.arrived += 1);
        const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        if (epoch !== this.epoch || order < this.painted || !this.photo || this.ending.signal.aborted) {
            bitmap.close();
            return;
        }
        this.painted = order;
        const { id, whole, part, columns, rows } = message;
        if (!this.stage.setPicture({ id, whole, part, columns, rows, bitmap })) {
            return;
        }
        this.root.dataset.shown = String(id);
        this.root.dataset.whole = String(whole);
        this.root.dispatchEvent(new CustomEvent("graphstipple-shown", { bubbles: true, detail: { id, whole } }));
    }

    drawnCame(message) {
        if (this.drawn && message.id < this.drawn.id) {
            return;
        }
        this.drawn = message;
        this.root.dataset.drawn = String(message.id);
        this.counts.show(message.stats, message.seconds, message.warnings ?? []);
        this.options.message.show("");
        this.paper.showSheet(message.sheet);
        this.stage.setSheet(message.sheet, this.state.look.settings.paper ?? "#ffffff");
        if (message.id === this.sent) {
            this.progress.end();
            this.output.setTexts(message);
            this.output.download.disabled = false;
        }
    }

    sizeCame({ id, suffix, bytes }) {
        if (id === this.sent && suffix === this.state.look.suffix) {
            this.counts.showSize(bytes);
            this.output.message.show("");
        }
    }

    fileCame({ name, mime }, bytes) {
        this.saving(false);
        this.output.message.show("");
        saveFile(name, mime, bytes);
    }

    async mapCame(bytes) {
        const { epoch } = this;
        const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        if (epoch === this.epoch) {
            this.saliency = saliencyOverlay(bitmap);
            this.showOverlay();
        }
        bitmap.close();
    }

    refused({ of, id, sentence }) {
        if (of === "draw" && (id === undefined || id === null || id === this.sent)) {
            this.progress.end();
            this.options.message.show(sentence);
        } else if (of === "photo") {
            this.isReopening = false;
            this.showName(this.photo?.name ?? "");
            this.photoMessage.show(sentence);
        } else if (of === "importance") {
            this.importance.message.show(sentence);
        } else if (of === "save") {
            this.counts.showSize(null);
            this.saving(false);
            this.output.message.show(sentence);
        }
    }

    // Photos

    /** Opens a file of the user's; it is kept for a desk that has lost it. */
    open(file) {
        if (!file) {
            return;
        }
        if (file.size > this.limits.upload) {
            const most = fileSize(this.limits.upload);
            this.photoMessage.show(`${file.name} has ${fileSize(file.size)}, and the studio takes ${most} at most.`);
            return;
        }
        this.photoMessage.show("");
        const open = () => {
            this.showName(`Opening ${file.name} …`);
            const refused = ({ message }) => this.refused({ of: "photo", sentence: message });
            this.transport.upload("photo", file.name, file).catch(refused);
        };
        this.source = { open };
        open();
    }

    showName(name) {
        this.name.textContent = name;
        this.name.title = name;
    }

    openExample() {
        this.source = { open: () => this.transport.send({ type: "example" }) };
        this.source.open();
    }

    // The state: look and strokes

    setLook(look, moving) {
        this.change({ look }, moving);
    }

    /** Strokes that are painted make the importance "painted"; without any it is what it was before. */
    setStrokes(strokes) {
        const { look, before } = this.state;
        const wasPainted = look.importance === "painted";
        const importance = strokes.length > 0 ? "painted" : wasPainted ? before : look.importance;
        this.change({ strokes, look: { ...look, importance }, before: wasPainted ? before : look.importance }, false);
    }

    /** Takes a change; while a slider moves it is no step yet. */
    change(changes, moving) {
        if (changes.look && changes.look.suffix !== this.state.look.suffix) {
            this.counts.showSize(null);
        }
        this.state = { ...this.state, ...changes };
        this.isMoving = moving;
        this.counts.setMoving(moving);
        if (moving) {
            this.drawSoon();
        } else {
            this.steps.add(this.state);
            this.rest();
        }
        this.refresh();
    }

    /** Undoes (-1) or does again (1) a step. */
    go(by) {
        if (!this.steps || this.stroke) {
            return;
        }
        this.steps.add(this.state);
        if (by < 0 ? !this.steps.canUndo : !this.steps.canRedo) {
            return;
        }
        this.state = this.steps.go(by);
        this.isMoving = false;
        this.counts.setMoving(false);
        this.rest();
        this.refresh();
    }

    /** Shows the state in all controls. */
    refresh() {
        const { look, strokes } = this.state;
        if (!look) {
            return;
        }
        this.presets.update(look);
        this.options.update(look);
        this.importance.update(look.importance, strokes.length > 0);
        this.paper.update(look);
        this.undo.disabled = !this.steps.canUndo;
        this.redo.disabled = !this.steps.canRedo;
        const format = this.book.formats.find(({ suffix }) => suffix === look.suffix);
        this.output.download.textContent = `Download ${format.name}`;
        this.showOverlay();
    }

    /** The state is at rest: drawn, after its map is with the desk, and kept in the address. */
    rest() {
        this.keep();
        if (this.isMapMissing()) {
            this.uploadMap();
        } else {
            this.draw(false);
        }
    }

    isMapMissing() {
        const { look, strokes } = this.state;
        return this.photo !== null && look.importance === "painted" && strokes.length > 0 && this.uploaded !== strokes;
    }

    /** Sends the painted map, the newest last, and draws then. */
    async uploadMap() {
        if (this.isUploading) {
            return;
        }
        this.isUploading = true;
        try {
            while (this.isMapMissing()) {
                const { strokes } = this.state;
                const blob = await this.mapBlob(strokes);
                await this.transport.upload("importance", "importance.png", blob);
                this.uploaded = strokes;
                this.importance.message.show("");
            }
            this.draw(false);
        } catch (error) {
            this.importance.message.show(error.message);
        } finally {
            this.isUploading = false;
        }
    }

    async mapBlob(strokes) {
        if (this.saved?.strokes !== strokes) {
            this.saved = { strokes, blob: await this.map.blob(strokes) };
        }
        return this.saved.blob;
    }

    async downloadMap() {
        saveFile("importance.png", "image/png", await this.mapBlob(this.state.strokes));
    }

    // What is told to the desk

    /** Draws while something moves: once it is clear that it has not come to rest already, as by a key, and at most once a frame. */
    drawSoon() {
        if (this.isFrameTaken) {
            this.isWaiting = true;
            return;
        }
        this.isFrameTaken = true;
        setTimeout(() => this.isMoving && this.draw(true));
        requestAnimationFrame(() => {
            this.isFrameTaken = false;
            if (this.isWaiting && this.isMoving) {
                this.drawSoon();
            }
        });
    }

    draw(moving) {
        this.isWaiting = false;
        if (!this.photo || !this.state.look) {
            return;
        }
        this.sent += 1;
        this.transport.send({ type: "draw", id: this.sent, look: tellable(this.book, this.state.look), moving });
        this.root.dataset.sent = String(this.sent);
        this.output.setTexts(null);
        if (this.root.dataset.state === "open") {
            this.progress.begin();
        }
    }

    /** What is seen has changed: told in this frame, if nothing was yet. */
    sees() {
        if (!this.view.isTaken) {
            this.view.isTaken = true;
            requestAnimationFrame(() => {
                this.view.isTaken = false;
                this.sendView();
            });
        }
    }

    sendView() {
        const seen = this.stage.viewport.seen;
        const told = JSON.stringify(seen);
        if (this.photo && seen && told !== this.view.told) {
            this.view.told = told;
            this.transport.send({ type: "view", ...seen });
        }
        this.showBrush();
    }

    save() {
        if (this.photo) {
            this.saving(true);
            this.output.message.show("");
            this.transport.send({ type: "save", id: this.sent, look: tellable(this.book, this.state.look) });
        }
    }

    saving(isSaving) {
        this.output.download.setAttribute("aria-busy", String(isSaving));
    }

    // The view

    setMode(mode) {
        this.views.choose(mode);
        this.stage.setMode(mode);
        this.stage.paint();
    }

    showZoom(scale) {
        const percent = scale * 100;
        this.zoom.textContent = `${percent < 10 ? percent.toFixed(1) : Math.round(percent)} %`;
    }

    // The brush

    brushChosen(kind) {
        this.stage.element.classList.toggle("gs-is-painting", kind !== null);
        this.brushAt = kind ? { point: [0.5, 0.5], pane: null } : null;
        this.showBrush();
        if (kind) {
            this.importance.setOverlay(true);
        }
    }

    showBrush() {
        this.stage.setBrush(this.photo ? this.brushAt : null, this.importance?.tools.size ?? 0);
    }

    /** What pointers do while the brush is on; null while it is off. */
    brush() {
        const tools = this.importance?.tools;
        if (!tools?.kind) {
            return null;
        }
        const hover = ([x, y]) => {
            this.brushAt = { point: this.stage.viewport.fractionAt(x, y), pane: this.stage.viewport.paneAt(x, y) };
            this.showBrush();
        };
        const add = (touches) => {
            for (const [[x, y], pressure] of touches) {
                this.stroke.points.push([...this.stage.viewport.fractionAt(x, y).map(fourDigits), fourDigits(pressure)]);
            }
            this.showOverlay();
        };
        const down = (touches) => {
            this.stroke = this.newStroke();
            add(touches);
        };
        const move = (touches) => this.stroke && add(touches);
        return { down, move, hover, up: () => this.endStroke(true), cancel: () => this.endStroke(false) };
    }

    newStroke() {
        const { kind, size, strength } = this.importance.tools;
        return { kind, size, strength: kind === "erase" ? 1 : strength, points: [] };
    }

    endStroke(isKept) {
        const { stroke } = this;
        this.stroke = null;
        if (stroke && isKept) {
            this.setStrokes([...this.state.strokes, stroke]);
        }
        this.showOverlay();
    }

    /** Arrow keys move the brush, Space paints with it. */
    brushKey(event) {
        const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
        const tools = this.importance?.tools;
        if (!tools?.kind || !this.brushAt || (!by && event.key !== " ")) {
            return false;
        }
        if (by) {
            const { width, height } = this.photo;
            const step = KEY_BRUSH * Math.max(width, height) * (event.shiftKey ? 5 : 1);
            const [x, y] = this.brushAt.point;
            const inside = (value) => Math.min(1, Math.max(0, value));
            this.brushAt = { point: [inside(x + by[0] * step / width), inside(y + by[1] * step / height)], pane: null };
            this.stage.reveal(this.brushAt.point);
            this.showBrush();
        } else if (!event.repeat) {
            this.stroke = this.newStroke();
            this.stroke.points.push([...this.brushAt.point.map(fourDigits), 1]);
            this.endStroke(true);
        }
        return true;
    }

    /** The overlay of the map that is in use, or that is being painted. */
    showOverlay() {
        const { importance } = this;
        if (!importance?.tools.isOverlay || !this.map) {
            this.stage.setOverlay(null);
        } else if (this.stroke || importance.tools.kind || this.state.look.importance === "painted") {
            this.paintOverlay();
        } else if (this.state.look.importance === "saliency") {
            this.askSaliency();
            this.stage.setOverlay(this.saliency);
        } else {
            this.stage.setOverlay(null);
        }
    }

    paintOverlay() {
        const points = this.stroke?.points.length ?? 0;
        const of = this.overlayOf;
        if (of?.map !== this.map || of.strokes !== this.state.strokes || of.stroke !== this.stroke || of.points !== points) {
            const canvas = this.map.overlay(this.state.strokes, this.stroke, of?.canvas);
            this.overlayOf = { map: this.map, strokes: this.state.strokes, stroke: this.stroke, points, canvas };
        }
        this.stage.setOverlay(this.overlayOf.canvas);
    }

    askSaliency() {
        if (!this.saliency && !this.isSaliencyAsked) {
            this.isSaliencyAsked = true;
            this.transport.send({ type: "saliency" });
        }
    }

    // The address, and what a reload keeps

    keep() {
        if (!this.transport.keepsAddress) {
            return;
        }
        clearTimeout(this.addressTimer);
        // At once, but not so often that browsers forbid it.
        const wait = this.keptAt + ADDRESS_MS - performance.now();
        if (wait <= 0) {
            this.keepNow();
        } else {
            this.addressTimer = setTimeout(() => this.keepNow(), wait);
        }
    }

    keepNow() {
        this.keptAt = performance.now();
        const text = lookToText(this.book, this.state.look);
        const plain = location.pathname + location.search;
        window.history.replaceState(null, "", text ? `${plain}#${text}` : plain);
        if (this.photo) {
            const { strokes, before } = this.state;
            const { width, height } = this.photo;
            try {
                sessionStorage.setItem(STORED_STROKES, JSON.stringify({ size: [width, height], strokes, before }));
            } catch {
                sessionStorage.removeItem(STORED_STROKES);
            }
        }
    }

    /** The strokes of this photo that were painted before a reload, or null. */
    storedStrokes() {
        if (!this.transport.keepsAddress) {
            return null;
        }
        try {
            const { size, strokes, before } = JSON.parse(sessionStorage.getItem(STORED_STROKES));
            const isOfPhoto = size[0] === this.photo.width && size[1] === this.photo.height;
            return isOfPhoto && strokes.length > 0 ? { strokes, before } : null;
        } catch {
            return null;
        }
    }

    addressChanged() {
        if (!this.book) {
            return;
        }
        const look = textToLook(this.book, location.hash);
        if (look.importance === "painted" && this.state.strokes.length === 0) {
            look.importance = "saliency";
        }
        if (!isSameLook(look, this.state.look)) {
            this.setLook(look, false);
        }
    }

    close() {
        this.ending.abort();
        clearTimeout(this.addressTimer);
        clearTimeout(this.missingTimer);
        this.progress.end();
        this.presets?.clear();
        this.stage.close();
        this.transport.close();
        this.root.replaceChildren();
        this.root.classList.remove("graphstipple-studio", "gs-page");
    }
}

/** Whether two states are the same: look and strokes. */
function isSameState(one, other) {
    return one.strokes === other.strokes && isSameLook(one.look, other.look);
}

/** Whether the focus is in a text that is being changed, which undoes by itself. */
function isBeingTyped(element) {
    return element instanceof HTMLTextAreaElement || element?.dataset?.typing === "true";
}

/** A fraction, short enough to be kept. */
function fourDigits(value) {
    return Math.round(value * 1e4) / 1e4;
}
