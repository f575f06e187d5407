/** Event streams: refused connections are reopened, hidden pages close theirs. */
import assert from "node:assert/strict";
import { beforeEach, mock, test } from "node:test";
import { eventStream } from "../api/event_stream.js";

/** @type {any[]} */
let sources = [];

class Source extends EventTarget {
  static CLOSED = 2;
  readyState = 1;

  /** @param {string} url */
  constructor(url) {
    super();
    this.url = url;
    sources.push(this);
  }

  close() {
    this.readyState = Source.CLOSED;
  }

  refuse() {
    this.close();
    this.dispatchEvent(new Event("error"));
  }

  /** @param {string} name @param {unknown} news */
  tell(name, news) {
    this.dispatchEvent(Object.assign(new Event(name), { data: JSON.stringify(news) }));
  }
}

const page = Object.assign(new EventTarget(), { hidden: false });
Object.assign(globalThis, { EventSource: Source, document: page });

/** @param {boolean} hidden */
function hide(hidden) {
  page.hidden = hidden;
  page.dispatchEvent(new Event("visibilitychange"));
}

/** Events received, in order. @param {string} url */
function heardOf(url) {
  /** @type {unknown[]} */
  const all = [];
  const hear = (/** @type {unknown} */ what) => void all.push(what);
  return { all, heard: { url, opened: hear, on: { news: hear } } };
}

beforeEach(() => {
  sources = [];
  page.hidden = false;
});

test("a refused connection is reopened and reports that events may be missed", () => {
  mock.timers.enable({ apis: ["setTimeout"] });
  const { all, heard } = heardOf("/a");
  eventStream().listen(heard);
  sources[0].dispatchEvent(new Event("open"));
  sources[0].tell("news", { n: 1 });
  sources[0].refuse();
  assert.equal(sources.length, 1);
  mock.timers.tick(3000);
  mock.timers.reset();
  assert.equal(sources.length, 2);
  sources[1].dispatchEvent(new Event("open"));
  sources[1].dispatchEvent(new Event("open"));
  assert.deepEqual(all, [false, { n: 1 }, true, false]);
});

test("the connection is closed while the page is hidden", () => {
  const { all, heard } = heardOf("/a");
  const stream = eventStream();
  stream.pauseWhileHidden();
  stream.listen(heard);
  hide(true);
  assert.equal(sources[0].readyState, Source.CLOSED);
  hide(false);
  sources[1].dispatchEvent(new Event("open"));
  assert.deepEqual(all, [true]);
  stream.listen(null);
  hide(true);
  hide(false);
  assert.equal(sources.length, 2, "nothing is listened to");
});

test("events of an ended subscription are dropped", () => {
  const [first, second] = [heardOf("/a"), heardOf("/b")];
  const stream = eventStream();
  stream.listen(first.heard);
  stream.listen(second.heard);
  sources[0].tell("news", 1);
  sources[1].tell("news", 2);
  assert.deepEqual([first.all, second.all], [[], [2]]);
  assert.deepEqual(
    sources.map((source) => source.url),
    ["/a", "/b"],
  );
});
