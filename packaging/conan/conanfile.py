"""Conan 2: conan create packaging/conan (the checkout is what is built)."""

from pathlib import Path

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy

COMPONENTS_OFF = ("APPS", "TESTS", "EXAMPLES", "PYTHON", "VTK", "OCCT", "MPI")


class Sightline(ConanFile):
    name = "sightline"
    version = "0.2.0"
    license = "MIT"
    description = "Scene-graph visibility middleware for CAD viewers"
    settings = "os", "compiler", "build_type", "arch"
    options = {"shared": [True, False], "gl": [True, False], "raytrace": [True, False]}
    default_options = {"shared": False, "gl": True, "raytrace": True}
    implements = ["auto_shared_fpic"]

    def export_sources(self):
        checkout = Path(self.recipe_folder).parents[1]
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "packaging/windows/*"):
            copy(self, pattern, checkout, self.export_sources_folder)
        for folder in ("analysis", "bindings", "core", "culling", "engine", "gl", "gpuprims", "gpuscene", "importers", "lod",
                       "raytrace", "render", "tests/support"):
            copy(self, f"{folder}/*", checkout, self.export_sources_folder)

    def requirements(self):
        for package in ("glm/cci.20230113", "tl-expected/1.1.0"):
            self.requires(package, transitive_headers=True)
        for package in ("fmt/9.1.0", "nlohmann_json/3.11.2", "libpng/1.6.43", "meshoptimizer/0.20", "draco/1.5.6",
                        "stb/cci.20230920", "xxhash/0.8.2"):
            self.requires(package)
        if self.options.gl:
            self.requires("opengl-registry/20240721", transitive_headers=True)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for part in COMPONENTS_OFF:
            toolchain.cache_variables[f"SIGHTLINE_{part}"] = False
        toolchain.cache_variables["SIGHTLINE_GL"] = bool(self.options.gl)
        toolchain.cache_variables["SIGHTLINE_RAYTRACE"] = bool(self.options.raytrace)
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, Path(self.package_folder) / "licenses")
        CMake(self).install()

    def package_info(self):
        # The CMake package that was installed says what there is.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = ["lib/cmake/Sightline"]
