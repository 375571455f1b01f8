#include "support.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace chiasm::fuzz {

namespace fs = std::filesystem;

const std::map<std::string, std::string>& seed_bundle() {
  static const auto& files = *new std::map<std::string, std::string>([] {
    std::map<std::string, std::string> read;
    for (const auto& entry : fs::directory_iterator(CHIASM_SEED_BUNDLE)) {
      std::ostringstream text;
      text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
      read[entry.path().filename()] = text.str();
    }
    if (read.count("manifest.json") == 0) throw std::runtime_error("no bundle in " CHIASM_SEED_BUNDLE);
    return read;
  }());
  return files;
}

const std::string& scratch_folder() {
  static const std::string& folder = *new std::string([] {
    std::string pattern = fs::exists("/dev/shm") ? "/dev/shm/chiasm-fuzz-XXXXXX" : "chiasm-fuzz-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    return pattern;
  }());
  static const int registered = std::atexit([] {
    std::error_code ignored;
    fs::remove_all(scratch_folder(), ignored);
  });
  (void)registered;
  return folder;
}

std::string fresh_folder(const std::string& name) {
  const std::string path = scratch_folder() + "/" + name;
  fs::remove_all(path);
  fs::create_directory(path);
  return path;
}

void write_file(const std::string& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(content.data(), static_cast<std::streamsize>(content.size()));
}

void write_seed(const std::string& path) {
  for (const auto& [name, content] : seed_bundle()) write_file(path + "/" + name, content);
}

void use_fake_backends() { ::setenv("CHIASM_BACKEND_PATH", CHIASM_FAKE_FOLDER, 1); }

}  // namespace chiasm::fuzz
