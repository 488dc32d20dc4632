// Where a value lies on its slider. In: the rule of an option. Out: functions between values and positions, 0 to 1.

const THIRD = 1 / 3;

/** A number with three digits, or a whole one, inside of what its rule allows. */
function rounded(rule, value) {
    const short = rule.isWhole ? Math.round(value) : Number(value.toPrecision(3));
    const least = rule.isOpen ? rule.high / 1000 : rule.low;
    return Math.min(rule.high, Math.max(least, short));
}

/** How strongly a scale is bent, so that the usual value lies a third along. */
function bend(rule, low, high) {
    const share = ((typeof rule.usual === "number" ? rule.usual : low) - low) / (high - low);
    if (high <= 4 || Math.abs(share - 0.5) <= 0.1) {
        return 1;
    }
    if (share <= 0 || share >= 1) {
        return high >= 100 ? 5 : 2;
    }
    return Math.max(1, Math.log(share) / Math.log(THIRD));
}

/** The slider of a rule, or null if it is better typed. `mostNodes` bounds what counts nodes. */
export function scaleOf(rule, mostNodes) {
    if (rule.isWhole && rule.high > 1e6 && rule.low === 0) {
        return null;
    }
    const high = rule.unit === "nodes" ? Math.min(rule.high, mostNodes) : rule.high;
    const low = rule.low;
    if (low > 0 && high / low > 1000) {
        const factor = Math.log(high / low);
        return makeScale(rule, low, high, (at) => low * Math.exp(at * factor), (value) => Math.log(value / low) / factor);
    }
    const power = bend(rule, low, high);
    const valueAt = (at) => low + (high - low) * at ** power;
    return makeScale(rule, low, high, valueAt, (value) => ((value - low) / (high - low)) ** (1 / power));
}

/** The scale of two functions: its values are short, its positions between 0 and 1. */
function makeScale(rule, low, high, valueAt, positionOf) {
    const inside = (value) => Math.min(high, Math.max(low, value));
    const value = (at) => rounded(rule, valueAt(Math.min(1, Math.max(0, at))));
    const position = (of) => positionOf(inside(of));
    const next = (from, steps) => {
        const to = value(position(from) + steps / 100);
        if (rule.isWhole && Math.abs(to - from) < Math.abs(steps)) {
            return rounded(rule, inside(from + steps));
        }
        return to;
    };
    return { value, position, next };
}
