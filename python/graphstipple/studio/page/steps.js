// Undo and redo. In: states at rest (any values that are never altered). Out: the state before, the state after.

/** A row of steps that begins with one state. */
export class Steps {
    constructor(state, isSame) {
        this.states = [state];
        this.at = 0;
        this.isSame = isSame;
    }

    get state() {
        return this.states[this.at];
    }

    get canUndo() {
        return this.at > 0;
    }

    get canRedo() {
        return this.at < this.states.length - 1;
    }

    /** Adds a step, unless nothing has changed; what was undone is gone then. */
    add(state) {
        if (this.isSame(this.state, state)) {
            return false;
        }
        this.states = [...this.states.slice(Math.max(0, this.at - 300), this.at + 1), state];
        this.at = this.states.length - 1;
        return true;
    }

    /** Goes `by` steps (-1 or 1) and returns the state there. */
    go(by) {
        this.at = Math.min(this.states.length - 1, Math.max(0, this.at + by));
        return this.state;
    }

    /** Alters every step, for example when another photo is opened. */
    rewrite(change) {
        this.states = this.states.map(change);
    }
}
