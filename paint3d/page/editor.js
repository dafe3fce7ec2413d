// The view of paint3d.page.editor: the page in a frame, and between the two what is painted.
function render({ model, el }) {
  const view = String(Math.random());
  const frame = document.createElement("iframe");
  frame.title = "paint3d";
  frame.allow = "fullscreen; hid";
  frame.style.cssText = `display: block; width: 100%; height: ${model.get("_height")}px; border: 0`;
  frame.srcdoc = model.get("_page");
  let isCurrent = false;
  const fromPage = ({ source, data }) => {
    if (source === frame.contentWindow && data?.paint3d !== undefined) model.send({ ...data, view });
  };
  const fromPython = (message) => {
    if (message.paint3d === "heard") {
      model.set("strokes", message.strokes); // from here, as a notebook that runs again by itself hears no other changes
      model.save_changes();
    } else if (message.view === view) {
      isCurrent = true;
      frame.contentWindow?.postMessage(message, "*");
    } else if (isCurrent) frame.replaceWith("This painting goes on where it was shown last.");
  };
  addEventListener("message", fromPage);
  model.on("msg:custom", fromPython);
  el.append(frame);
  return () => {
    removeEventListener("message", fromPage);
    model.off("msg:custom", fromPython);
  };
}
export default { render };
