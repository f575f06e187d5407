/** The part of htm's interface that the page uses. */
declare const htm: {
  bind(h: (type: any, props: any, ...children: any[]) => object): (strings: TemplateStringsArray, ...values: any[]) => any;
};
export default htm;
