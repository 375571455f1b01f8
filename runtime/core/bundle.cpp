#include "core/bundle.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "core/status.h"

namespace chiasm::core {
namespace {

std::string read_manifest_text(const std::string& folder) {
  struct stat info {};
  if (::stat(folder.c_str(), &info) != 0) {
    fail(CHIASM_NOT_FOUND, "cannot open the bundle " + folder + ": " + std::strerror(errno));
  }
  if (!S_ISDIR(info.st_mode)) fail(CHIASM_CORRUPT, folder + " is not a bundle: a bundle is a folder");
  const std::string path = folder + "/manifest.json";
  if (::stat(path.c_str(), &info) != 0) fail(CHIASM_CORRUPT, folder + " is not a bundle: there is no manifest.json in it");
  const Bytes bytes = read_file(path, kMaxManifestSize);
  return std::string(bytes.begin(), bytes.end());
}

}  // namespace

Bundle::Bundle(const char* path) : path_(path) {
  while (path_.size() > 1 && path_.back() == '/') path_.pop_back();
  text_ = read_manifest_text(path_);
  manifest_ = parse_manifest(text_, file_path("manifest.json"));
  methods_.reserve(manifest_.methods.size());
  for (const MethodSpec& method : manifest_.methods) {
    methods_.emplace_back(method, manifest_.symbols, manifest_.dtypes);
    method_infos_.push_back(methods_.back().get());
  }
  info_.struct_size = sizeof info_;
  info_.name = manifest_.name.c_str();
  info_.version = manifest_.version.c_str();
  info_.summary = manifest_.summary.c_str();
  info_.path = path_.c_str();
  info_.method_count = static_cast<int32_t>(method_infos_.size());
  info_.methods = method_infos_.data();
  info_.manifest = text_.c_str();
}

const MethodSpec& Bundle::method(const char* name) const {
  std::string all;
  for (const MethodSpec& method : manifest_.methods) {
    if (method.name == name) return method;
    all += (all.empty() ? "" : ", ") + method.name;
  }
  fail(CHIASM_NOT_FOUND, path_ + " has no method '" + name + "'; it has " + all);
}

}  // namespace chiasm::core
