// Pixels of PNG files, read inside the page.

/**
 * Runs a function in the page on the pixels of PNG files.
 * @param page
 * @param {Buffer[]} files
 * @param {(images: ImageData[], given: any) => any} look runs in the page: it sees nothing else
 * @param given passed on
 */
export async function onPixels(page, files, look, given = null) {
  await page.evaluate(() => {
    globalThis.pixelsOf ??= async (base64) => {
      const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
      const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
      const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
      context.drawImage(image, 0, 0);
      return context.getImageData(0, 0, image.width, image.height);
    };
  });
  const images = await page.evaluateHandle(
    (all) => Promise.all(all.map(globalThis.pixelsOf)),
    files.map((file) => file.toString("base64")),
  );
  const result = await images.evaluate(look, given);
  await images.dispose();
  return result;
}
