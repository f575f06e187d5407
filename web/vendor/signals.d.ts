/** The part of @preact/signals' interface that the page uses: it makes components follow signals. */
export {};
