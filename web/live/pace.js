/**
 * How fine the drawing buffer is, from how long frames take: where software draws, as fine as 25 frames a second allow; on
 * hardware, as every frame of the display allows. Owns the rule; reads no clock but the one that is handed to it.
 */

/** The drawing buffer over the canvas, at the least. */
const LEAST_RATIO = 0.3;
/** Slower than this, in milliseconds a frame, and the buffer shrinks; faster than that, and it grows. */
const SLOW_MS = 40;
const QUICK_MS = 30;
/** By how much it grows at once: from where it is quick, not to where it is slow. */
const GROWTH = 1.1;
/** No step down is longer than this. */
const SHRINKING = 0.6;
/** Frames over which the pace is judged, of which the slowest, which something else may have held up, does not count. */
const JUDGED = 12;
const DROPPED = 1;
/** Over the display's own interval: slower than this, and one more of them than that misses a frame of the display. */
const MISSED = 1.08;
/** Over the same: sooner than that, and it is another display's interval. */
const SOONER = 0.9;
/** Where a buffer of the least size takes this much of the time of a whole one, drawing is not what takes it. */
const NO_QUICKER = 0.75;
/** Judgements until something that failed is tried again; each time it fails again, as many again. */
const PATIENCE = 20;
const LONGEST_PATIENCE = 320;
/** Frames without drawing by which the display's interval is told, and how much later than those in time are the late ones. */
const WATCHED = 20;
const LATE = 1.3;

/** @param {number[]} values @returns {number[]} */
const sorted = (values) => values.sort((a, b) => a - b);

/** @param {number[]} values @returns {number} */
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

export class Pace {
  ratio = 1;
  #slow = SLOW_MS;
  #quick = QUICK_MS;
  /** The display's own interval, where that is aimed at. @type {number|null} */
  #interval = null;
  /** @type {number|null} */
  #last = null;
  /** @type {number[]} */
  #steps = [];
  /** Whether the last judgement made the buffer finer. */
  #grown = false;
  /** Milliseconds a frame before the buffer was made coarser. */
  #whole = 0;
  /** Judgements during which nothing is made finer, or, where drawing is not what takes time, nothing coarser either. */
  #waits = 0;
  #resigned = false;
  #patience = PATIENCE;

  /**
   * Every frame of the display is wanted, not only those of 25 a second.
   * @param {number} interval_ms between two frames of the display
   */
  aimAt(interval_ms) {
    this.#interval = interval_ms;
    this.#slow = Math.min(SLOW_MS, MISSED * interval_ms);
    this.#quick = Math.min(QUICK_MS, this.#slow);
  }

  /**
   * One frame more while the light moves and nothing else takes time.
   * @param {number} now milliseconds
   * @returns {boolean} whether the ratio has changed
   */
  step(now) {
    if (this.#last !== null) this.#steps.push(now - this.#last);
    this.#last = now;
    if (this.#steps.length < JUDGED) return false;
    const counted = sorted(this.#steps).slice(0, JUDGED - DROPPED);
    this.#steps = [];
    const before = this.ratio;
    this.#judge(mean(counted));
    return this.ratio !== before;
  }

  /** @param {number} taken milliseconds a frame */
  #judge(taken) {
    const { ratio } = this;
    if (this.#waits > 0) this.#waits -= 1;
    else this.#resigned = false;
    const grown = this.#grown;
    this.#grown = false;
    // The window came to a quicker display.
    if (this.#interval !== null && taken < SOONER * this.#interval) this.aimAt(taken);
    if (taken > this.#slow) {
      if (this.#resigned) return;
      if (grown) {
        this.ratio = ratio / GROWTH;
        this.#wait();
      } else if (ratio === LEAST_RATIO) {
        if (taken < NO_QUICKER * this.#whole) return;
        this.ratio = 1;
        this.#resigned = true;
        this.#wait();
        // Or to a slower one.
        if (this.#interval !== null) this.aimAt(taken);
      } else {
        if (ratio === 1) this.#whole = taken;
        this.ratio = Math.max(LEAST_RATIO, ratio * Math.max(SHRINKING, Math.sqrt(this.#slow / taken)));
      }
    } else if (taken < this.#quick && ratio < 1 && this.#waits === 0) {
      this.ratio = Math.min(1, ratio * GROWTH);
      this.#grown = true;
    }
  }

  #wait() {
    this.#waits = this.#patience;
    this.#patience = Math.min(LONGEST_PATIENCE, 2 * this.#patience);
  }

  /** The light rests: the next movement is judged anew. */
  pause() {
    this.#last = null;
    this.#steps = [];
  }
}

/**
 * Milliseconds between two frames of the display while nothing is drawn: the mean of those that are not late, as a page that has
 * just been opened has many of.
 * @param {(tick: (now: number) => void) => unknown} nextFrame
 * @returns {Promise<number>}
 */
export function displayInterval(nextFrame = requestAnimationFrame) {
  return new Promise((done) => {
    /** @type {number[]} */
    const steps = [];
    /** @type {number|null} */
    let last = null;
    /** @param {number} now */
    const tick = (now) => {
      if (last !== null) steps.push(now - last);
      last = now;
      if (steps.length < WATCHED) nextFrame(tick);
      else {
        const first = sorted(steps)[WATCHED >> 2];
        done(mean(steps.filter((step) => step < LATE * first)));
      }
    };
    nextFrame(tick);
  });
}
