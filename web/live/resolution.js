/**
 * Adaptive resolution of the drawing buffer from measured frame times. Software renderers aim at 25
 * frames a second, hardware at every frame of the display. Reads no clock itself.
 */

/** Least resolution relative to the canvas. */
const LEAST_RATIO = 0.3;
/** Milliseconds a frame above which the resolution falls, and below which it rises. */
const SLOW_MS = 40;
const QUICK_MS = 30;
/** Factor of one rise: from a quick frame it does not lead to a slow one. */
const GROWTH = 1.1;
/** Largest fall in one step. */
const SHRINKING = 0.6;
/**
 * Number of frames that are judged together, and number of the slowest of them that do not count,
 * because other work may have delayed them.
 */
const JUDGED = 12;
const DROPPED = 1;
/** Relative to the display's interval: a mean above this misses frames of the display. */
const MISSED = 1.08;
/** Relative to the display's interval: a mean below this means a faster display. */
const SOONER = 0.9;
/**
 * Relative to the time at full resolution: if the least resolution takes more than this, the number
 * of pixels is not what makes drawing slow.
 */
const NO_QUICKER = 0.75;
/** Judgements before a failed change is tried again; doubles with each failure. */
const PATIENCE = 20;
const LONGEST_PATIENCE = 320;
/**
 * Frames without drawing from which the display's interval is measured, and the factor beyond which
 * a frame is late.
 */
const WATCHED = 20;
const LATE = 1.3;

/** @param {number[]} values @returns {number[]} */
const sorted = (values) => values.sort((a, b) => a - b);

/** @param {number[]} values @returns {number} */
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

export class AdaptiveResolution {
  /** Resolution of the drawing buffer relative to the canvas. */
  ratio = 1;
  /** Milliseconds a frame above which the resolution falls, and below which it rises. */
  #slow = SLOW_MS;
  #quick = QUICK_MS;
  /** The display's interval if that is the aim, else null. @type {number|null} */
  #interval = null;
  /** Time of the last frame, milliseconds. @type {number|null} */
  #last = null;
  /** Milliseconds between frames since the last judgement. @type {number[]} */
  #steps = [];
  /** True if the last judgement raised the resolution. */
  #grown = false;
  /** Milliseconds a frame at full resolution, before it fell. */
  #whole = 0;
  /** Number of judgements before the next rise; after resigning also before the next fall. */
  #waits = 0;
  /** True while full resolution is kept although it is slow, because the least was no faster. */
  #resigned = false;
  /** Number of judgements to wait after the next failed change. */
  #patience = PATIENCE;

  /**
   * Aims at every frame of the display instead of 25 a second.
   * @param {number} interval_ms between two frames of the display
   */
  aimAt(interval_ms) {
    this.#interval = interval_ms;
    this.#slow = Math.min(SLOW_MS, MISSED * interval_ms);
    this.#quick = Math.min(QUICK_MS, this.#slow);
  }

  /**
   * Counts one more frame, while the light moves and nothing else takes time.
   * @param {number} now milliseconds
   * @returns {boolean} true if the ratio has changed
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
    // The window was moved to a faster display.
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
        // The window was moved to a slower display.
        if (this.#interval !== null) this.aimAt(taken);
      } else {
        if (ratio === 1) this.#whole = taken;
        this.ratio = Math.max(
          LEAST_RATIO,
          ratio * Math.max(SHRINKING, Math.sqrt(this.#slow / taken)),
        );
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

  /** Discards the running measurement because drawing pauses. */
  pause() {
    this.#last = null;
    this.#steps = [];
  }
}

/**
 * Measures the display's interval while nothing is drawn: the mean of frames that are not late, of
 * which a page that has just been opened has many.
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
