# Recipe for Spack 1.0 or later: packaging/spack/spack.yaml makes an environment of it.
from pathlib import Path

from spack_repo.builtin.build_systems.cmake import CMakePackage, generator
from spack_repo.builtin.build_systems.cuda import CudaPackage

from spack.package import *


class Kedge(CMakePackage, CudaPackage):
    """Material point method for rigid anchors, plates, cones and ploughs in soil at large deformation."""

    git = Path(__file__).resolve().parents[6].as_uri()  # the repository that this recipe is part of

    license("GPL-3.0-or-later")

    version("main", branch="main")

    variant("native", default=False, description="Tune the code for the processor it is built on")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.20:", type="build")
    depends_on("ninja", type="build")
    depends_on("mpi")
    # The versions that Kedge is tested with, on Debian 12 and 13.
    depends_on("dealii@9.4:9.6 +mpi+p4est+hdf5+trilinos+threads")
    depends_on("boost@:1.88")  # deal.II asks for a library Boost.System, which later ones do not have
    depends_on("trilinos+mpi+kokkos+tpetra+belos+muelu+ifpack2+amesos2 gotype=long_long cxxstd=17")
    depends_on("trilinos@13.2", when="~cuda")
    with when("+cuda"):
        conflicts("cuda_arch=none", msg="Name the GPU: cuda_arch=90 for H100")
        depends_on("dealii@9.6~cuda")
        depends_on("trilinos@14.4:16 +wrapper~uvm")
        depends_on("kokkos+cuda_lambda+cuda_constexpr")
        for arch in CudaPackage.cuda_arch_values:
            depends_on(f"trilinos+cuda cuda_arch={arch}", when=f"cuda_arch={arch}")
    depends_on("suite-sparse")
    depends_on("hdf5+mpi")
    depends_on("eigen@3.4")
    depends_on("nlohmann-json@3.11:3")
    depends_on("cli11@2.1:2")
    depends_on("fmt@9:10")
    depends_on("cgal@5.5:6")
    depends_on("muparser")
    depends_on("zlib-api")
    depends_on("py-numpy", type="run")
    depends_on("py-scipy", type="run")
    depends_on("py-matplotlib", type="run")
    depends_on("py-pillow", type="run")
    depends_on("py-jsonschema", type="run")

    generator("ninja")

    def cmake_args(self):
        compiler = [self.define("CMAKE_CXX_COMPILER", self["trilinos"].kokkos_cxx)] if "+cuda" in self.spec else []
        return [
            self.define_from_variant("KEDGE_NATIVE", "native"),
            self.define("KEDGE_TESTS", False),
            self.define("KEDGE_BENCHMARKS", False),
            self.define("KEDGE_PRECOMPILED", False),
        ] + compiler

    def test_cube(self):
        """a cube under its weight is compressed, as prm/cube.json says"""
        kedge = which(self.prefix.bin.kedge, required=True)
        kedge("run", self.prefix.share.kedge.prm.join("cube.json"))
