// Common parts of the drawings on canvases.

export const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
export const radians = (degrees) => degrees * Math.PI / 180;

/** The context of a canvas, cleared, with its size in CSS pixels. */
export function fresh(canvas) {
  const ratio = devicePixelRatio || 1;
  canvas.dataset.width ??= canvas.width;
  canvas.dataset.height ??= canvas.height;
  const [width, height] = [Number(canvas.dataset.width), Number(canvas.dataset.height)];
  if (canvas.width !== Math.round(width * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    canvas.style.width = `${width}px`;
    canvas.style.aspectRatio = `${width} / ${height}`;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

/** Writes on a canvas that something is unknown. */
export function unknown({ context, width, height }, what) {
  context.fillStyle = style("--soft");
  context.textAlign = "center";
  context.font = "14px system-ui, sans-serif";
  context.fillText(`no ${what}`, width / 2, height / 2);
}
