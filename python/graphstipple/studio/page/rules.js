// What each option takes. In: the JSON schema of options. Out: rules, and checks, values read from and written as text.

/** The rule of one property of the schema. */
function ruleOf(name, property) {
    const kinds = property.anyOf ?? [property];
    const number = kinds.find((kind) => kind.type === "number" || kind.type === "integer");
    return {
        name,
        description: property.description ?? "",
        group: property["x-group"] ?? "Other",
        isEveryday: property["x-everyday"] === true,
        unit: property["x-unit"] ?? "",
        usual: property.default ?? null,
        isSwitch: kinds.some((kind) => kind.type === "boolean"),
        words: kinds.filter((kind) => kind.enum).flatMap((kind) => kind.enum),
        pattern: kinds.find((kind) => kind.pattern)?.pattern ?? null,
        isList: property["x-list"] === true,
        isNumber: number !== undefined,
        isWhole: number?.type === "integer",
        low: number?.minimum ?? number?.exclusiveMinimum ?? 0,
        isOpen: number?.exclusiveMinimum !== undefined,
        high: number?.maximum ?? Number.MAX_SAFE_INTEGER,
        absent: kinds.some((kind) => kind.type === "null") ? property["x-absent"] ?? { word: "off", meaning: "" } : null,
    };
}

/** The rules of all options by their full names, in the order of the schema. */
export function rulesOf(schema) {
    const rules = new Map();
    for (const [name, property] of Object.entries(schema.properties)) {
        if (property.properties) {
            for (const [inner, each] of Object.entries(property.properties)) {
                rules.set(`${name}.${inner}`, ruleOf(`${name}.${inner}`, each));
            }
        } else {
            rules.set(name, ruleOf(name, property));
        }
    }
    return rules;
}

/** Whether an option takes a value. */
export function isAllowed(rule, value) {
    if (value === null) {
        return rule.absent !== null;
    }
    if (typeof value === "boolean") {
        return rule.isSwitch;
    }
    if (typeof value === "string") {
        return rule.words.includes(value) || (rule.pattern !== null && new RegExp(rule.pattern).test(value));
    }
    const isInside = value <= rule.high && (rule.isOpen ? value > rule.low : value >= rule.low);
    return rule.isNumber && isInside && (!rule.isWhole || Number.isSafeInteger(value));
}

/** The value that a text means, or undefined if the option takes no such value. */
export function readValue(rule, text) {
    const word = text.trim();
    const number = word !== "" && /^[-+.\deE]+$/.test(word) ? Number(word) : NaN;
    const candidates = [word];
    if (rule.absent?.word === word) {
        candidates.unshift(null);
    }
    if (rule.isSwitch && (word === "true" || word === "false")) {
        candidates.unshift(word === "true");
    }
    if (rule.isNumber && Number.isFinite(number)) {
        candidates.unshift(number);
    }
    return candidates.find((value) => isAllowed(rule, value));
}

/** A value as text, which readValue takes. */
export function writeValue(rule, value) {
    return value === null ? rule.absent?.word ?? "off" : String(value);
}
