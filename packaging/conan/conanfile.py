"""chiasm's runtime for Conan 2: libchiasm and the native backend, built from this source tree.

    conan create packaging/conan

A consumer has `find_package(chiasm CONFIG)` and `chiasm::chiasm`, as by every other route. libsodium and
nlohmann-json come from Debian, and stand in the libraries: a consumer needs neither.
"""

import re
from pathlib import Path

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load
from conan.tools.system.package_manager import Apt


class Chiasm(ConanFile):
    name = "chiasm"
    description = "Runs bundles of computer-vision ops: compiled code, in C and C++, without Python"
    license = "Apache-2.0"
    topics = ("computer-vision", "image-processing", "inference")
    package_type = "shared-library"
    settings = "os", "arch", "compiler", "build_type"

    @property
    def _tree(self) -> Path:
        return Path(self.recipe_folder).parents[1]

    def set_version(self) -> None:
        text = load(self, str(self._tree / "CMakeLists.txt"))
        self.version = re.search(r"project\(chiasm VERSION (\S+)", text).group(1)

    def export_sources(self) -> None:
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "include/*", "runtime/*"):
            copy(self, pattern, str(self._tree), self.export_sources_folder)

    def validate(self) -> None:
        check_min_cppstd(self, 17)

    def system_requirements(self) -> None:
        Apt(self).install(["libsodium-dev", "nlohmann-json3-dev"])

    def layout(self) -> None:
        cmake_layout(self)

    def generate(self) -> None:
        toolchain = CMakeToolchain(self)
        for part in ("ARTIFACT", "BACKEND_ONNX", "BACKEND_TORCH", "PYTHON", "TESTS", "TRITON"):
            toolchain.cache_variables[f"CHIASM_{part}"] = False
        toolchain.generate()

    def build(self) -> None:
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self) -> None:
        copy(self, "LICENSE", self.source_folder, str(Path(self.package_folder, "licenses")))
        CMake(self).install()

    def package_info(self) -> None:
        # Its own CMake package and pkg-config file are the ones to find.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [str(Path("lib", "cmake", "chiasm"))]
        self.cpp_info.libs = ["chiasm"]
