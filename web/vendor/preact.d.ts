/** The part of preact's interface that the page uses. */
export type VNode = object;
export function h(type: unknown, props: Record<string, unknown> | null, ...children: unknown[]): VNode;
export function render(vnode: unknown, parent: Element): void;
export function Fragment(props: { children?: unknown }): VNode;
