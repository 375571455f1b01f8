// Runs an op on a picture: RGBA in, RGBA out. A graph is fetched at its first use and kept.
import * as ort from "./ort/ort.wasm.min.mjs";

ort.env.wasm.wasmPaths = new URL("./ort/", import.meta.url).href;
ort.env.wasm.numThreads = 1;
ort.env.logLevel = "error";

const ARRAYS = { float32: Float32Array, int64: BigInt64Array };
const sessions = new Map();

function tensorOf({ shape, dtype, value }) {
  const count = shape.reduce((product, size) => product * size, 1);
  return new ort.Tensor(dtype, ARRAYS[dtype].from({ length: count }, () => (dtype === "int64" ? BigInt(value) : value)), shape);
}

function withoutAlpha(data) {
  const result = new Uint8Array((data.length / 4) * 3);
  for (let i = 0, j = 0; i < data.length; i += 4) {
    result[j++] = data[i];
    result[j++] = data[i + 1];
    result[j++] = data[i + 2];
  }
  return result;
}

// Of one channel or three.
function withAlpha(data, pixels) {
  const result = new Uint8ClampedArray(pixels * 4);
  const channels = data.length / pixels;
  for (let i = 0; i < pixels; ++i) {
    for (let c = 0; c < 3; ++c) result[4 * i + c] = data[i * channels + Math.min(c, channels - 1)];
    result[4 * i + 3] = 255;
  }
  return result;
}

onmessage = async ({ data: { op, width, height, data } }) => {
  try {
    if (!sessions.has(op.op)) sessions.set(op.op, await ort.InferenceSession.create(`${op.op}.onnx`));
    const session = sessions.get(op.op);
    const feeds = { [op.image]: new ort.Tensor("uint8", withoutAlpha(data), [1, height, width, 3]) };
    for (const setting of op.settings ?? []) feeds[setting.name] = tensorOf(setting);
    const started = performance.now();
    const output = (await session.run(feeds))[op.output ?? "output"];
    const milliseconds = performance.now() - started;
    const [, rows, columns] = output.dims;
    const pixels = withAlpha(output.data, rows * columns);
    postMessage({ op: op.op, width: columns, height: rows, data: pixels, milliseconds }, [pixels.buffer]);
  } catch (error) {
    postMessage({ op: op.op, refused: String(error?.message ?? error) });
  }
};
