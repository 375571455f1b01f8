// Runs one graph on one golden case. A request names the graph and its inputs, with their bytes; the answer has the
// outputs with theirs, or says why the engine refused.
import * as ort from "/ort/ort.wasm.min.mjs";

ort.env.wasm.wasmPaths = "/ort/";
ort.env.wasm.numThreads = 1;
ort.env.logLevel = "error";

const ARRAYS = {
  bool: Uint8Array,
  float16: globalThis.Float16Array ?? Uint16Array,
  float32: Float32Array,
  float64: Float64Array,
  int8: Int8Array,
  int16: Int16Array,
  int32: Int32Array,
  int64: BigInt64Array,
  uint8: Uint8Array,
  uint16: Uint16Array,
};

onmessage = async ({ data: request }) => {
  try {
    const started = performance.now();
    const session = await ort.InferenceSession.create(request.graph);
    const feeds = {};
    for (const { name, dtype, shape, data } of request.inputs) {
      feeds[name] = new ort.Tensor(dtype, new ARRAYS[dtype](data.buffer), shape);
    }
    const loaded = performance.now();
    const results = await session.run(feeds);
    const ran = performance.now();
    const outputs = session.outputNames.map((name) => {
      const { type, dims, data } = results[name];
      return { dtype: type, shape: [...dims], data: new Uint8Array(data.buffer, data.byteOffset, data.byteLength) };
    });
    await session.release();
    postMessage({ outputs, load_ms: loaded - started, run_ms: ran - loaded });
  } catch (error) {
    postMessage({ refused: String(error?.message ?? error) });
  }
};
