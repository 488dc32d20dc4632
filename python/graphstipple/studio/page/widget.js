// The studio in a notebook, for anywidget. In: the widget's model and its element. Out: the studio in it, and what takes it away.

import { mount } from "./studio.js";

/** The transport over a widget's model. */
function openModel(model) {
    const transport = { keepsAddress: false, onmessage: null, onstate: null, send, upload, close };

    function send(message) {
        model.send(message);
    }

    async function upload(kind, name, blob) {
        const bytes = new Uint8Array(await blob.arrayBuffer());
        model.send({ type: kind === "photo" ? "open" : kind, name }, undefined, [bytes.buffer]);
    }

    function received(content, buffers) {
        const view = buffers?.[0];
        const bytes = view ? new Uint8Array(view.buffer ?? view, view.byteOffset ?? 0, view.byteLength) : null;
        transport.onmessage?.(content, bytes);
    }

    function close() {
        model.off("msg:custom", received);
    }

    model.on("msg:custom", received);
    return transport;
}

export default {
    render({ model, el }) {
        el.setAttribute("data-lm-suppress-shortcuts", "true");
        const transport = openModel(model);
        const unmount = mount(el, transport);
        transport.onstate?.("open", "");
        transport.send({ type: "hello" });
        return unmount;
    },
};
