"""The program that is built by every route (tests/consumer/cpp), with Conan's package."""

import os
from pathlib import Path

from conan import ConanFile
from conan.tools.build import can_run
from conan.tools.cmake import CMake, cmake_layout


class Consumer(ConanFile):
    settings = "os", "arch", "compiler", "build_type"
    generators = "CMakeToolchain", "CMakeDeps", "VirtualRunEnv"

    def requirements(self) -> None:
        self.requires(self.tested_reference_str)

    def layout(self) -> None:
        self.folders.root = "../../.."
        cmake_layout(self, src_folder="tests/consumer/cpp", build_folder="build/conan/test")

    def build(self) -> None:
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def test(self) -> None:
        if can_run(self):
            bundle = os.environ.get("CHIASM_CONSUMER_BUNDLE", "")
            program = Path(self.build_folder, self.cpp.build.bindir, "consumer")
            self.run(f'"{program}" {bundle}', env="conanrun")
