#include "tensors.h"

#include "base/dtype.h"

#include <dlpack/dlpack.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace chiasm::python {
namespace {

// Version 1 of DLPack. Distributions have the header of version 0.6, which lacks it.
struct VersionedTensor {
  uint32_t major, minor;
  void* manager_ctx;
  void (*deleter)(VersionedTensor* self);
  uint64_t flags;
  DLTensor tensor;
};
constexpr uint64_t kReadOnly = 1, kIsCopied = 2;
constexpr int kBool = 6;                 // kDLBool
constexpr double kLeastLargest = 65504;  // float16's largest value: every floating-point dtype holds it
constexpr const char* kNoCapsule = "its memory cannot be had through DLPack";
constexpr const char* kCapsule = "dltensor";
constexpr const char* kVersionedCapsule = "dltensor_versioned";

using base::kDTypeCount;
using base::kDTypes;

uint8_t bits_of(int32_t dtype) { return static_cast<uint8_t>(8 * kDTypes[dtype].size); }

int32_t dtype_from_dlpack(const DLDataType& type) {
  if (type.lanes != 1) return -1;
  for (int32_t i = 0; i < kDTypeCount; ++i) {
    if (kDTypes[i].dlpack == type.code && bits_of(i) == type.bits) return i;
  }
  return -1;
}

// -1 for a dtype that chiasm does not have, and for one in the other byte order.
int32_t dtype_from_numpy(const py::dtype& dtype) {
  if (dtype.byteorder() == '>') return -1;
  const char kind = dtype.kind();
  const auto bits = dtype.itemsize() * 8;
  for (int32_t i = 0; i < kDTypeCount; ++i) {
    if (kDTypes[i].numpy_kind == kind && bits_of(i) == bits && kind != 'V') return i;
  }
  // A dtype of the package ml_dtypes: NumPy gives all types that it does not know the kind 'V'.
  return kind == 'V' && bits == 16 && py::str(dtype).cast<std::string>() == "bfloat16" ? CHIASM_BFLOAT16 : -1;
}

py::dtype numpy_dtype(int32_t dtype) {
  static PyObject* known[kDTypeCount] = {};  // guarded by the GIL, and kept
  if (known[dtype] == nullptr) {
    py::object found;
    const base::DTypeEntry& entry = kDTypes[dtype];
    if (entry.numpy_kind != 'V') {
      found = py::dtype(entry.numpy_kind + std::to_string(entry.size));
    } else {
      try {
        found = py::dtype::from_args(py::module_::import("ml_dtypes").attr(entry.name));
      } catch (const py::error_already_set&) {
        throw Error(CHIASM_INVALID_ARGUMENT,
                    std::string("NumPy has no ") + entry.name + ": pass torch tensors, or install ml_dtypes");
      }
    }
    known[dtype] = found.release().ptr();
  }
  return py::reinterpret_borrow<py::dtype>(known[dtype]);
}

DLDataType dlpack_dtype(int32_t dtype) {
  DLDataType result;
  result.code = static_cast<uint8_t>(kDTypes[dtype].dlpack);
  result.bits = bits_of(dtype);
  result.lanes = 1;
  return result;
}

DLDevice dlpack_device(const chiasm_tensor& tensor) {
  DLDevice device;
  device.device_type = tensor.device_type == CHIASM_CUDA ? kDLCUDA : kDLCPU;
  device.device_id = tensor.device_index;
  return device;
}

// What we use of torch, looked up once.
struct Torch {
  PyTypeObject* tensor;
  py::object to_dlpack, from_dlpack;
};

// NULL until torch is imported: a program that holds one of its tensors has imported it. Never destroyed.
const Torch* imported_torch() {
  static const Torch* instance = nullptr;  // guarded by the GIL
  if (instance != nullptr) return instance;
  PyObject* found = PyDict_GetItemString(PyImport_GetModuleDict(), "torch");
  if (found == nullptr || !py::hasattr(found, "Tensor")) return nullptr;  // not (completely) imported
  const py::module_ dlpack = py::module_::import("torch.utils.dlpack");
  instance = new Torch{
      reinterpret_cast<PyTypeObject*>(py::handle(found).attr("Tensor").cast<py::object>().release().ptr()),
      dlpack.attr("to_dlpack"), dlpack.attr("from_dlpack")};
  return instance;
}

bool is_torch_tensor(py::handle object) {
  const Torch* torch = imported_torch();
  return torch != nullptr && PyObject_TypeCheck(object.ptr(), torch->tensor) != 0;
}

// Whether the array is of a subclass of NumPy's array that has a mask.
bool is_masked(py::handle array) {
  static PyTypeObject* plain = nullptr;  // guarded by the GIL, and kept
  if (plain == nullptr) {
    const py::object type = py::module_::import("numpy").attr("ndarray");
    plain = reinterpret_cast<PyTypeObject*>(type.inc_ref().ptr());
  }
  return Py_TYPE(array.ptr()) != plain && py::hasattr(array, "mask");
}

// The name of the object's class, as C has it: a metaclass may define __name__.
std::string type_name(py::handle object) {
  const std::string name = Py_TYPE(object.ptr())->tp_name;
  return name.substr(name.rfind('.') + 1);
}

// The first line of an exception's message, which code of its class may make.
std::string first_line(const py::error_already_set& error) {
  const py::object text = py::reinterpret_steal<py::object>(PyObject_Str(error.value().ptr()));
  if (!text) {
    PyErr_Clear();
    return "";
  }
  const std::string whole = text_of(text);
  return whole.substr(0, whole.find('\n'));
}

// Inside it NumPy does not warn of overflows.
class WithoutWarning {
 public:
  explicit WithoutWarning(const py::module_& numpy)
      : state_(numpy.attr("errstate")(py::arg("over") = "ignore")) {
    state_.attr("__enter__")();
  }
  WithoutWarning(const WithoutWarning&) = delete;
  WithoutWarning& operator=(const WithoutWarning&) = delete;
  ~WithoutWarning() {
    const py::error_scope pending;  // of the block
    try {
      state_.attr("__exit__")(py::none(), py::none(), py::none());
    } catch (py::error_already_set& error) {
      error.discard_as_unraisable("chiasm");
    }
  }

 private:
  py::object state_;
};

// A DLPack tensor of ours, with everything that it points to.
template <class Managed>
struct Exported {
  Managed managed{};
  Output::Outputs outputs;
  std::array<int64_t, CHIASM_MAX_DIMS> shape, strides;
};

template <class Managed>
void delete_exported(Managed* managed) {
  delete static_cast<Exported<Managed>*>(managed->manager_ctx);
}

template <class Managed>
void delete_unused(PyObject* capsule, const char* name) {
  if (PyCapsule_IsValid(capsule, name) == 0) return;  // somebody took it, and renamed the capsule
  auto* managed = static_cast<Managed*>(PyCapsule_GetPointer(capsule, name));
  managed->deleter(managed);
}

void fill(DLTensor& target, const chiasm_tensor& tensor, int64_t* shape, int64_t* strides) {
  target.data = tensor.data;
  target.device = dlpack_device(tensor);
  target.ndim = tensor.ndim;
  target.dtype = dlpack_dtype(tensor.dtype);
  target.shape = shape;
  target.strides = strides;
  target.byte_offset = 0;
  int64_t step = 1;
  for (int32_t i = tensor.ndim; i-- > 0;) {
    shape[i] = tensor.shape[i];
    strides[i] = step;
    step *= tensor.shape[i];
  }
}

}  // namespace

py::str decoded(const std::string& text) {
  PyObject* made =
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "backslashreplace");
  if (made == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(made);
}

std::string text_of(py::handle text) {
  const auto bytes =
      py::reinterpret_steal<py::bytes>(PyUnicode_AsEncodedString(text.ptr(), "utf-8", "backslashreplace"));
  if (!bytes) throw py::error_already_set();
  return bytes;
}

std::string described(py::handle object) {
  constexpr size_t kMost = 60;
  if (object.is_none()) return "None";
  std::string type = type_name(object);
  const bool is_text = PyUnicode_CheckExact(object.ptr()) != 0;
  if (!is_text && PyLong_CheckExact(object.ptr()) == 0 && PyFloat_CheckExact(object.ptr()) == 0) return type;
  const auto shown = py::reinterpret_steal<py::object>(PyObject_Repr(object.ptr()));
  if (!shown) {  // an integer of thousands of digits
    PyErr_Clear();
    return type;
  }
  const std::string text = text_of(shown);
  return text.size() > kMost ? type : is_text ? text : text + " (" + type + ")";
}

const char* dtype_name(int32_t dtype) {
  return dtype >= 0 && dtype < kDTypeCount ? kDTypes[dtype].name : "unknown";
}

int32_t dtype_from_name(const std::string& name) {
  for (int32_t i = 0; i < kDTypeCount; ++i) {
    if (name == kDTypes[i].name) return i;
  }
  throw Error(CHIASM_INVALID_ARGUMENT, "unknown dtype '" + name + "'");
}

Arguments::Arguments(Role role, size_t count) : role_(role) {
  views_.reserve(count);
  storage_.reserve(count);
  owners_.reserve(count);
}

void Arguments::refuse(const chiasm_tensor_info& info, const std::string& why) const {
  throw Error(CHIASM_INVALID_ARGUMENT,
              std::string(role_ == Role::input ? "input '" : "output '") + info.name + "': " + why);
}

template <class Make>
py::object Arguments::taken(const chiasm_tensor_info& info, const char* what, const Make& make) const {
  try {
    return make();
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_Exception)) throw;  // KeyboardInterrupt
    refuse(info, std::string(what) + " (" + type_name(error.value()) + ": " + first_line(error) +
                     "); pass a dense array or tensor on the CPU or CUDA");
  }
}

void Arguments::add(py::handle object, const chiasm_tensor_info& info) {
  if (py::isinstance<py::array>(object)) {
    if (is_masked(object))
      refuse(info, "its mask would be left out; pass array.filled(value), or array.data for all its values");
    add_array(py::reinterpret_borrow<py::array>(object), info);
  } else if (is_torch_tensor(object)) {
    has_torch_ = true;
    if (object.attr("requires_grad").cast<bool>())
      refuse(info,
             "the tensor requires grad, and a run is not recorded by autograd; pass tensor.detach(), or run "
             "the method 'vjp'");
    // DLPack ignores torch's negative bit: it shows the values in memory. (Only complex tensors have a
    // conjugate bit, and chiasm has no complex dtypes.)
    if (object.attr("is_neg")().cast<bool>())
      refuse(info,
             "the tensor's values are the negatives of what its memory holds (its negative bit is set); "
             "pass tensor.resolve_neg()");
    // Not object.__dlpack__(), which is Python code and takes ten times as long.
    add_dlpack(taken(info, kNoCapsule, [&] { return imported_torch()->to_dlpack(object); }), info);
  } else if (py::hasattr(object, "__dlpack__")) {
    const auto capsule = [&]() -> py::object {
      try {
        return object.attr("__dlpack__")(py::arg("max_version") = py::make_tuple(1, 0));
      } catch (py::error_already_set& error) {
        if (!error.matches(PyExc_TypeError)) throw;
        return object.attr("__dlpack__")();  // written before version 1 of the protocol
      }
    };
    add_dlpack(taken(info, kNoCapsule, capsule), info);
  } else if (role_ == Role::input &&
             (py::isinstance<py::float_>(object) || py::isinstance<py::int_>(object) ||
              py::isinstance<py::bool_>(object))) {
    add_array(number(object, info), info);
  } else if (py::isinstance<py::bytes>(object)) {  // for NumPy a text
    refuse(info, "expected an array, got bytes; pass numpy.frombuffer(data, dtype).reshape(shape)");
  } else if (PyObject_CheckBuffer(object.ptr()) != 0 || py::hasattr(object, "__array_interface__")) {
    if (role_ == Role::output && py::hasattr(object, "__array_interface__"))
      refuse(info, "cannot write into a " + type_name(object) + "; pass a NumPy array or a torch tensor");
    const auto array = [&] { return py::module_::import("numpy").attr("asarray")(object); };
    add_array(py::array(taken(info, "NumPy does not take it", array)), info);
  } else {
    refuse(info, "expected an array (NumPy, torch, or any with __dlpack__), got " + type_name(object));
  }
}

chiasm_tensor& Arguments::append(const chiasm_tensor_info& info, int64_t ndim) {
  if (ndim < 0 || ndim > CHIASM_MAX_DIMS)
    refuse(info, "has " + std::to_string(ndim) + " dimensions, not 0 to " + std::to_string(CHIASM_MAX_DIMS));
  storage_.push_back(std::make_unique<Storage>());
  chiasm_tensor view{};
  view.struct_size = sizeof(view);
  view.device_type = CHIASM_CPU;
  view.ndim = static_cast<int32_t>(ndim);
  view.shape = storage_.back()->shape.data();
  view.strides = storage_.back()->strides.data();
  views_.push_back(view);
  return views_.back();
}

int32_t Arguments::number_dtype(const chiasm_tensor_info& info) const {
  return info.dtype_count > 1 && generic_dtype_ >= 0 ? generic_dtype_ : info.dtypes[0];
}

py::array Arguments::number(py::handle object, const chiasm_tensor_info& info) const {
  const int32_t code = number_dtype(info);
  const bool is_float = kDTypes[code].numpy_kind == 'f' || kDTypes[code].numpy_kind == 'V';
  const py::dtype dtype = numpy_dtype(code);
  try {
    const py::module_ numpy = py::module_::import("numpy");
    const double given = is_float ? PyFloat_AsDouble(object.ptr()) : 0;
    if (PyErr_Occurred() != nullptr) throw py::error_already_set();
    std::optional<WithoutWarning> quiet;  // only for numbers that may become infinite: it takes microseconds
    if (!(std::abs(given) <= kLeastLargest)) quiet.emplace(numpy);
    py::object made = numpy.attr("asarray")(object, dtype);
    const py::object value = made.attr("item")();
    if (is_float ? std::isfinite(value.cast<double>()) || !std::isfinite(given) : value.equal(object))
      return made;
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_Exception)) throw;  // KeyboardInterrupt
  }
  refuse(info, "expected a value of " + std::string(dtype_name(code)) + ", got " + described(object));
}

void Arguments::add_array(py::array array, const chiasm_tensor_info& info) {
  const py::dtype dtype = array.dtype();
  const int32_t code = dtype_from_numpy(dtype);
  if (code < 0) refuse(info, "chiasm has no dtype " + py::str(dtype).cast<std::string>());
  if (role_ == Role::output && !array.writeable()) refuse(info, "the array is read-only");
  chiasm_tensor& view = append(info, array.ndim());
  view.data = const_cast<void*>(array.data());
  view.dtype = code;
  const py::ssize_t size = dtype.itemsize();
  for (py::ssize_t i = 0; i < array.ndim(); ++i) {
    storage_.back()->shape[static_cast<size_t>(i)] = array.shape(i);
    const py::ssize_t bytes = array.strides(i);
    if (array.shape(i) > 1 && bytes % size != 0)
      refuse(info, "its elements do not lie on multiples of their size; pass numpy.ascontiguousarray(array)");
    storage_.back()->strides[static_cast<size_t>(i)] = bytes / size;
  }
  if (generic_dtype_ < 0 && info.dtype_count > 1) generic_dtype_ = code;
  owners_.push_back(std::move(array));
}

void Arguments::add_dlpack(py::object capsule, const chiasm_tensor_info& info) {
  const DLTensor* tensor = nullptr;
  if (PyCapsule_IsValid(capsule.ptr(), kVersionedCapsule) != 0) {
    auto* managed = static_cast<VersionedTensor*>(PyCapsule_GetPointer(capsule.ptr(), kVersionedCapsule));
    if (managed->major != 1)
      refuse(info, "its DLPack version is " + std::to_string(managed->major) + ", not 1");
    if (role_ == Role::output && (managed->flags & kReadOnly) != 0) refuse(info, "the tensor is read-only");
    if (role_ == Role::output && (managed->flags & kIsCopied) != 0)
      refuse(info, "its __dlpack__ returned a copy, and the results would be written into that copy");
    tensor = &managed->tensor;
  } else if (PyCapsule_IsValid(capsule.ptr(), kCapsule) != 0) {
    tensor = &static_cast<DLManagedTensor*>(PyCapsule_GetPointer(capsule.ptr(), kCapsule))->dl_tensor;
  } else {
    refuse(info, "__dlpack__ did not return a DLPack capsule");
  }
  const int32_t code = dtype_from_dlpack(tensor->dtype);
  if (code < 0)
    refuse(info, "chiasm has none of its dtype (DLPack code " + std::to_string(tensor->dtype.code) + ", " +
                     std::to_string(tensor->dtype.bits) + " bits)");
  chiasm_tensor& view = append(info, tensor->ndim);
  view.data = static_cast<char*>(tensor->data) + tensor->byte_offset;
  view.dtype = code;
  switch (tensor->device.device_type) {
    case kDLCPU:
    case kDLCUDAHost: break;
    case kDLCUDA:
      view.device_type = CHIASM_CUDA;
      view.device_index = tensor->device.device_id;
      cuda_device_ = view.device_index;
      break;
    default:
      refuse(info, "it is on a device that is neither the CPU nor CUDA (DLPack device type " +
                       std::to_string(static_cast<int>(tensor->device.device_type)) + ")");
  }
  std::copy_n(tensor->shape, tensor->ndim, storage_.back()->shape.begin());
  // PyTorch's tensors without elements have no data, which the core takes for a mistake.
  alignas(64) static char nothing[64];
  if (view.data == nullptr &&
      std::find(tensor->shape, tensor->shape + tensor->ndim, 0) != tensor->shape + tensor->ndim)
    view.data = nothing;
  if (tensor->strides == nullptr) {
    view.strides = nullptr;
  } else {
    std::copy_n(tensor->strides, tensor->ndim, storage_.back()->strides.begin());
  }
  if (generic_dtype_ < 0 && info.dtype_count > 1) generic_dtype_ = code;
  owners_.push_back(std::move(capsule));  // not renamed: the capsule itself frees the tensor when we drop it
}

Output::Output(Outputs outputs, size_t index)
    : outputs_(std::move(outputs)), tensor_(api().outputs_get(outputs_.get(), index)) {}

py::capsule Output::capsule(bool versioned) const {
  if (versioned) {
    auto exported = std::make_unique<Exported<VersionedTensor>>();
    exported->managed = {1, 0, exported.get(), delete_exported<VersionedTensor>, 0, {}};
    exported->outputs = outputs_;
    fill(exported->managed.tensor, *tensor_, exported->shape.data(), exported->strides.data());
    PyObject* capsule = PyCapsule_New(&exported->managed, kVersionedCapsule, [](PyObject* self) {
      delete_unused<VersionedTensor>(self, kVersionedCapsule);
    });
    if (capsule == nullptr) throw py::error_already_set();
    static_cast<void>(exported.release());  // it is the capsule's
    return py::reinterpret_steal<py::capsule>(capsule);
  }
  auto exported = std::make_unique<Exported<DLManagedTensor>>();
  exported->managed.manager_ctx = exported.get();
  exported->managed.deleter = delete_exported<DLManagedTensor>;
  exported->outputs = outputs_;
  fill(exported->managed.dl_tensor, *tensor_, exported->shape.data(), exported->strides.data());
  PyObject* capsule = PyCapsule_New(&exported->managed, kCapsule,
                                    [](PyObject* self) { delete_unused<DLManagedTensor>(self, kCapsule); });
  if (capsule == nullptr) throw py::error_already_set();
  static_cast<void>(exported.release());  // it is the capsule's
  return py::reinterpret_steal<py::capsule>(capsule);
}

py::tuple Output::device() const {
  const DLDevice device = dlpack_device(*tensor_);
  return py::make_tuple(static_cast<int>(device.device_type), device.device_id);
}

py::tuple Output::shape() const {
  py::tuple result(tensor_->ndim);
  for (int32_t i = 0; i < tensor_->ndim; ++i) result[static_cast<size_t>(i)] = py::int_(tensor_->shape[i]);
  return result;
}

py::object Output::to_numpy() const {
  if (tensor_->device_type != CHIASM_CPU)
    throw Error(
        CHIASM_INVALID_ARGUMENT,
        "NumPy arrays are on the CPU and this output is on CUDA: ask for returns='torch' or 'dlpack'");
  const py::capsule owner(new Outputs(outputs_), [](void* p) { delete static_cast<Outputs*>(p); });
  return py::array(numpy_dtype(tensor_->dtype),
                   std::vector<py::ssize_t>(tensor_->shape, tensor_->shape + tensor_->ndim), tensor_->data,
                   owner);
}

py::object Output::to(Library library) const {
  switch (library) {
    case Library::numpy: return to_numpy();
    case Library::torch: {
      if (imported_torch() == nullptr) py::module_::import("torch");
      const Torch* torch = imported_torch();
      if (torch == nullptr)
        throw Error(CHIASM_FAILED_PRECONDITION,
                    "torch is only being imported: its tensors cannot be made yet");
      return torch->from_dlpack(capsule(false));
    }
    default: return py::cast(*this);
  }
}

}  // namespace chiasm::python
