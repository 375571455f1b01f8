// The page: pictures from a file, a drop or the camera, the op that is chosen, its settings. Ops run in live_worker.mjs.
const SIDE = 640; // pixels of the longer side of what is computed
const element = (id) => document.getElementById(id);
const [before, after, video] = ["before", "after", "video"].map(element);
const source = before.getContext("2d", { willReadFrequently: true });

const ops = await (await fetch("ops.json")).json();
const worker = new Worker("live_worker.mjs", { type: "module" });
let chosen = ops[0];
let busy = false; // while the worker computes
let stale = false; // what is shown is of another picture or setting

function show(op) {
  chosen = op;
  element("settings").replaceChildren(
    ...(op.settings ?? [])
      .filter((setting) => "least" in setting)
      .map((setting) => {
        const label = document.createElement("label");
        const range = Object.assign(document.createElement("input"), {
          type: "range", min: setting.least, max: setting.most, step: setting.step, value: setting.value, name: setting.name,
        });
        const text = document.createElement("output");
        text.textContent = range.value;
        range.addEventListener("input", () => {
          setting.value = Number(range.value);
          text.textContent = range.value;
          compute();
        });
        label.append(setting.name, range, text);
        return label;
      }),
  );
  compute();
}

element("ops").append(
  ...ops.map((op, i) => {
    const label = document.createElement("label");
    const radio = Object.assign(document.createElement("input"), { type: "radio", name: "op", value: op.op, checked: i === 0 });
    radio.addEventListener("change", () => show(op));
    label.append(radio, op.title);
    return label;
  }),
);

// Draw a picture, no larger than is computed.
function draw(picture, width, height) {
  const scale = Math.min(1, SIDE / Math.max(width, height));
  before.width = Math.max(8, Math.round(width * scale));
  before.height = Math.max(8, Math.round(height * scale));
  source.drawImage(picture, 0, 0, before.width, before.height);
  compute();
}

function compute() {
  if (busy) {
    stale = true;
    return;
  }
  busy = true;
  stale = false;
  const { width, height } = before;
  const { data } = source.getImageData(0, 0, width, height);
  worker.postMessage({ op: chosen, width, height, data }, [data.buffer]);
}

worker.addEventListener("message", ({ data: answer }) => {
  busy = false;
  const status = element("status");
  if (answer.refused === undefined) {
    after.width = answer.width;
    after.height = answer.height;
    after.getContext("2d").putImageData(new ImageData(answer.data, answer.width, answer.height), 0, 0);
    status.textContent = `${answer.op}: ${answer.milliseconds.toFixed(1)} ms for ${before.width} x ${before.height}, on one thread`;
    after.dataset.op = answer.op;
    after.dataset.settled = String(!stale);
  } else {
    status.textContent = `${answer.op} did not run: ${answer.refused}`;
  }
  if (stale) compute();
});

// The worker's script, or what it imports, did not load or failed. It answers no more.
worker.addEventListener("error", ({ message }) => {
  element("status").textContent = `The ops do not run here: ${message || "ONNX Runtime could not be loaded"}`;
});

async function open(file) {
  stopCamera();
  try {
    const picture = await createImageBitmap(file);
    draw(picture, picture.width, picture.height);
  } catch {
    element("status").textContent = `${file.name} is no picture that this browser opens`;
  }
}

function stopCamera() {
  for (const track of video.srcObject?.getTracks() ?? []) track.stop();
  video.srcObject = null;
  element("camera").textContent = "Open the camera";
}

element("camera").addEventListener("click", async () => {
  if (video.srcObject) return stopCamera();
  try {
    video.srcObject = await navigator.mediaDevices.getUserMedia({ video: { facingMode: "environment" } });
  } catch (error) {
    element("status").textContent = `The camera cannot be opened: ${error.message}`;
    return;
  }
  element("camera").textContent = "Stop the camera";
  await video.play();
  const next = () => {
    if (!video.srcObject) return;
    if (!busy) draw(video, video.videoWidth, video.videoHeight);
    video.requestVideoFrameCallback(next);
  };
  video.requestVideoFrameCallback(next);
});

element("file").addEventListener("change", ({ target }) => target.files[0] && open(target.files[0]));
document.addEventListener("dragover", (event) => {
  event.preventDefault();
  document.body.classList.add("dropping");
});
document.addEventListener("dragleave", () => document.body.classList.remove("dropping"));
document.addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("dropping");
  if (event.dataTransfer.files[0]) open(event.dataTransfer.files[0]);
});

const photograph = await createImageBitmap(await (await fetch("photograph.jpg")).blob());
show(chosen);
draw(photograph, photograph.width, photograph.height);
