// The pictures of the drawing that are there. In: pictures of parts as they come. Out: which to paint, from below to above.

const MOST = 4;
const SLACK = 1e-3;

/** Pictures are {id, whole, part, columns, rows, bitmap}. */
export class Pictures {
    constructor() {
        this.list = [];
    }

    /** Takes a picture in; what it covers as well or better is let go. */
    add(picture) {
        const better = this.list.some((old) => old.id === picture.id && old.whole && !picture.whole && covers(old, picture));
        if (better) {
            picture.bitmap.close();
            return false;
        }
        const isBetter = (old) => old.id < picture.id || picture.whole > old.whole || density(old) <= density(picture) * 1.01;
        const isSpent = (old) => covers(picture, old) && isBetter(old);
        const kept = this.list.filter((old) => !isSpent(old));
        const spent = [...this.list.filter(isSpent), ...kept.splice(0, Math.max(0, kept.length - MOST + 1))];
        spent.forEach((old) => old.bitmap.close());
        this.list = [...kept, picture];
        return true;
    }

    /** Lets all go. */
    clear() {
        this.list.forEach((picture) => picture.bitmap.close());
        this.list = [];
    }
}

/** Whether one picture's part has all of another's in it. */
function covers(one, other) {
    const [left, top, right, bottom] = one.part;
    const [left2, top2, right2, bottom2] = other.part;
    return left <= left2 + SLACK && top <= top2 + SLACK && right >= right2 - SLACK && bottom >= bottom2 - SLACK;
}

/** Pixels of a picture for a pixel of the canvas. */
function density(picture) {
    return picture.columns / (picture.part[2] - picture.part[0]);
}
