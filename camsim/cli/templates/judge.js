"use strict";
// Linked crops: every panel shows the same window of its own picture, one canvas pixel being a whole part of a pixel.
for (const box of document.querySelectorAll(".judge")) {
  const data = JSON.parse(box.querySelector("script").textContent);
  const holder = box.querySelector(".panels"), where = box.querySelector(".where");
  const state = { x: 0, y: 0, zoom: 4, errors: false, cols: 0, rows: 0 };
  const panels = data.panels.map((panel) => {
    const figure = document.createElement("figure"), canvas = document.createElement("canvas");
    const caption = document.createElement("figcaption"), name = document.createElement("b");
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", panel.told);
    name.textContent = panel.told;
    caption.append(name, panel.cpsnr);
    figure.append(canvas, caption);
    holder.append(figure);
    const load = (url) => {
      if (!url) return null;
      const image = new Image();
      image.onload = () => {
        if (!state.cols) { state.cols = image.width; state.rows = image.height; state.x = image.width / 2; state.y = image.height / 2; }
        draw();
      };
      image.src = url;
      return image;
    };
    return { canvas, picture: load(panel.picture), error: load(panel.error) };
  });
  function draw() {
    const ratio = window.devicePixelRatio || 1;
    let left = 0, top = 0;
    for (const { canvas, picture, error } of panels) {
      const side = Math.max(1, Math.round(canvas.clientWidth * ratio));
      if (canvas.width !== side) canvas.width = canvas.height = side;
      const size = state.zoom * Math.max(1, Math.round(ratio)), span = side / size;
      left = Math.round(Math.min(Math.max(state.x - span / 2, 0), Math.max(0, state.cols - span)));
      top = Math.round(Math.min(Math.max(state.y - span / 2, 0), Math.max(0, state.rows - span)));
      const image = state.errors && error ? error : picture, context = canvas.getContext("2d");
      context.imageSmoothingEnabled = false;
      context.clearRect(0, 0, side, side);
      if (image.complete) context.drawImage(image, -left * size, -top * size, image.width * size, image.height * size);
    }
    where.textContent = `from row ${data.row + top}, column ${data.col + left}`;
  }
  function move(dx, dy) {
    const side = panels[0].canvas.clientWidth / state.zoom / 2;
    const within = (value, all) => Math.min(Math.max(value, Math.min(side, all / 2)), Math.max(all - side, all / 2));
    state.x = within(state.x + dx, state.cols);
    state.y = within(state.y + dy, state.rows);
    draw();
  }
  function zoom(to) {
    state.zoom = to;
    for (const button of box.querySelectorAll("[data-zoom]")) button.setAttribute("aria-pressed", String(+button.dataset.zoom === to));
    move(0, 0);
  }
  for (const button of box.querySelectorAll("[data-zoom]")) button.addEventListener("click", () => zoom(+button.dataset.zoom));
  box.querySelector(".errors").addEventListener("change", (event) => { state.errors = event.target.checked; draw(); });
  for (const { canvas } of panels) {
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) move(-event.movementX / state.zoom, -event.movementY / state.zoom);
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoom(Math.min(8, Math.max(1, event.deltaY < 0 ? state.zoom * 2 : state.zoom / 2)));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-8, 0], ArrowRight: [8, 0], ArrowUp: [0, -8], ArrowDown: [0, 8] }[event.key];
      if (step) { event.preventDefault(); move(step[0], step[1]); }
    });
  }
  new ResizeObserver(draw).observe(holder);
}
