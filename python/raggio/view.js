// The browser's side of raggio.view: shows frames, and tells what the mouse does.
//
// Each frame that is on the screen is acknowledged, and the next one comes only then. What the mouse does is told once for
// each picture of the screen, as parts of the view's height.
export default {
  render({ model, el }) {
    const picture = document.createElement("img");
    const status = document.createElement("div");
    picture.draggable = false;
    picture.className = "raggio-view";
    Object.assign(picture.style, { display: "block", maxWidth: "100%", cursor: "grab", touchAction: "none" });
    Object.assign(status.style, { font: "12px sans-serif", opacity: 0.7, minHeight: "1.4em" });
    el.append(picture, status);

    function show(message, buffers) {
      if (message.error !== undefined) {
        status.textContent = message.error;
        return;
      }
      const url = URL.createObjectURL(new Blob([buffers[0]], { type: "image/png" }));
      picture.onload = picture.onerror = () => {
        URL.revokeObjectURL(url);
        model.send({ shown: message.frame });
      };
      picture.src = url;
      picture.width = message.width;
      picture.style.aspectRatio = `${message.width} / ${message.height}`;
      picture.dataset.samples = message.samples;
      picture.dataset.frame = message.frame;
      status.textContent = `${message.samples} of ${message.of} samples`;
    }

    let moved = {};
    function move(kind, x, y) {
      if (Object.keys(moved).length === 0) {
        requestAnimationFrame(() => {
          model.send({ move: moved });
          moved = {};
        });
      }
      const [x0, y0] = moved[kind] ?? [0, 0];
      moved[kind] = [x0 + x, y0 + y];
    }

    // Dragging turns the camera around its target; with the right button, or Shift, it moves both.
    picture.onpointerdown = (event) => {
      const pans = event.button === 2 || event.shiftKey;
      let [x, y] = [event.clientX, event.clientY];
      picture.setPointerCapture(event.pointerId);
      picture.onpointermove = (event) => {
        const height = picture.clientHeight || 1;
        move(pans ? "pan" : "orbit", (event.clientX - x) / height, (event.clientY - y) / height);
        [x, y] = [event.clientX, event.clientY];
      };
      picture.onpointerup = picture.onpointercancel = () => {
        picture.onpointermove = picture.onpointerup = picture.onpointercancel = null;
      };
      event.preventDefault();
    };
    // Wheels count in pixels, lines or pages.
    picture.onwheel = (event) => {
      event.preventDefault();
      move("dolly", 0, event.deltaY * [1, 20, 400][event.deltaMode]);
    };
    picture.oncontextmenu = (event) => event.preventDefault();
    picture.ondblclick = () => model.send({ reset: true });

    model.on("msg:custom", show);
    model.send({ opened: true });
    return () => {
      model.off("msg:custom", show);
      model.send({ closed: true });
    };
  },
};
