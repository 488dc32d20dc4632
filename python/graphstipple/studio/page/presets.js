// The presets as small drawings of the photo. In: presets, pictures as they come. Out: the part of the panel that chooses.

import { make, radioGroup, section } from "./elements.js";

/** The section "Look"; `choose(name)` is called with the preset that is chosen. */
export function presetsSection(presets, choose) {
    const pictures = new Map();
    const items = presets.map((preset) => {
        const picture = make("img", { alt: "", hidden: true });
        pictures.set(preset.name, picture);
        const frame = make("span", { class: "gs-thumb" }, picture);
        const attributes = { class: "gs-preset", "data-preset": preset.name, title: preset.description };
        return { value: preset.name, content: [frame, make("span", { text: preset.name })], attributes };
    });
    const group = radioGroup("Preset", "gs-presets", items, choose);
    const drop = (picture) => {
        if (picture.src) {
            URL.revokeObjectURL(picture.src);
            picture.removeAttribute("src");
        }
        picture.hidden = true;
    };
    const show = (name, bytes) => {
        const picture = pictures.get(name);
        if (picture) {
            drop(picture);
            picture.src = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
            picture.hidden = false;
        }
    };
    const clear = () => pictures.forEach(drop);
    return { element: section("Look", group.element), update: (look) => group.choose(look.preset), show, clear };
}
