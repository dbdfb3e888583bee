// Time per particle of the kernels of a Newton iteration: stress and internal force, tangent scattered into the matrix.
#include <benchmark/benchmark.h>
#include <cmath>
#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/system.h>
#include <kedge/basis/active_nodes.h>
#include <kedge/basis/gimp.h>
#include <kedge/particles/generation.h>
#include <memory>

using namespace kedge;

namespace
{
constexpr unsigned int cells = 12;
constexpr double cell = 0.25;

/// Soil with 2^3 particles per cell under pressure and shear. Moved by `shift` of a cell along every axis, each box
/// reaches into the neighbouring cells: 27 nodes per particle instead of 8.
struct Block
{
  Block(const unsigned int law, const double shift) : mesh(MPI_COMM_SELF, layout()), particles(mesh)
  {
    MaterialPointParameters parameters;
    Layer layer;
    layer.thickness = cells * cell;
    layer.material.law = law;
    layer.material.young = 1e7;
    layer.material.poisson = 0.3;
    layer.material.density = 2000.;
    layer.material.constants.values = {{"friction angle", 35.}, {"dilation angle", 5.}, {"cohesion", 1e3}};
    parameters.layers = {layer};
    parameters.K0 = 0.5;
    generate_particles(particles, mesh, parameters, 9.81);
    set_state_at_rest(particles, mesh.layout(), parameters, 9.81);
    move(shift);
    materials = upload_materials({layer.material});
    discretise();
  }

  static GridLayout<3> layout()
  {
    GridLayout<3> grid;
    grid.base_size = grid.finest_size = cell;
    grid.base_cells = {{cells, cells, 2 * cells}};
    grid.soil_extent = {{cells * cell, cells * cell, cells * cell}};
    return grid;
  }

  void move(const double shift)
  {
    ParticleIncrements increments;
    increments.displacement = kedge::View<double* [3]>("displacement", particles.ids().size());
    increments.deformation_gradient = kedge::View<double* [9]>("dF", particles.ids().size());
    const auto u = copy_to_host(increments.displacement);
    const auto f = copy_to_host(increments.deformation_gradient);
    for (std::size_t p = 0; p < particles.ids().size(); ++p)
      for (unsigned int d = 0; d < 3; ++d)
      {
        // towards the faces that the two particles of a cell do not share, and away from the grid's boundary
        const double x = particles.positions()[p][d] / cell;
        const bool upper = x - std::floor(x) > 0.5;
        u(p, d) = cell * shift * (x < 0.5 ? 1. : x > cells - 0.5 && d < 2 ? -1. : upper ? 1. : -1.);
        f(p, 4 * d) = 1.;
      }
    Kokkos::deep_copy(increments.displacement, u);
    Kokkos::deep_copy(increments.deformation_gradient, f);
    particles.commit(increments, DomainUpdate::none);
  }

  void discretise()
  {
    const LeafTable<3>& table = mesh.leaves();
    HostStencils host = build_stencils<3>(
        table, find_box_parts<3>(table, particles.positions(), particles.half_widths(), particles.leaves()));
    std::vector<unsigned char> used(table.node_ids.size(), 0);
    for (const unsigned int node : host.pattern_nodes)
      used[node] = 1;
    const ActiveNodes nodes = number_active_nodes<3>(table, used, MPI_COMM_SELF);
    stencils = upload_stencils<3>(std::move(host), nodes.number);
    system =
        std::make_unique<System>(3, NodeNumbering{nodes.communicator, nodes.n_owned, nodes.global, nodes.ghost_begin},
                                 std::vector<NodeLists>{{stencils.pattern_node_begin, stencils.pattern_nodes}},
                                 std::vector<unsigned char>(3 * nodes.n_local(), 0));
    // horizontal shear and settlement: a good part of the frictional soil yields
    increment = system->make_nodal_vector();
    const auto u = copy_to_host(increment);
    for (unsigned int v = 0; v < nodes.n_local(); ++v)
    {
      const auto& x = table.node_position[nodes.mesh_node[v]];
      u(3 * v) = 2e-3 * x[2] + 3e-4 * std::sin(7. * x[1]);
      u(3 * v + 2) = -1e-3 * x[2] + 3e-4 * std::sin(9. * x[0]);
    }
    Kokkos::deep_copy(increment, u);
    force = system->make_nodal_vector();
  }

  void report(benchmark::State& state) const
  {
    const auto n = static_cast<std::int64_t>(particles.arrays().n);
    const auto plastic = copy_to_host(particles.arrays().trial_plastic);
    const auto total = copy_to_host(stencils.value_begin)(n);
    double yielding = 0.;
    for (std::int64_t p = 0; p < n; ++p)
      yielding += plastic(p) > 0.;
    state.SetItemsProcessed(state.iterations() * n);
    state.counters["nodes"] = double(total) / n;
    state.counters["yielding"] = yielding / n;
    state.counters["s/particle"] =
        benchmark::Counter(double(n), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  }

  BackgroundMesh<3> mesh;
  ParticleSet<3> particles;
  Materials materials;
  StencilSet stencils;
  std::unique_ptr<System> system;
  NodalVector increment, force;
};

void stress_and_force(benchmark::State& state, const unsigned int law, const double shift)
{
  const Block block(law, shift);
  for (auto _ : state)
    update_stress_and_force<3>(block.particles.arrays(), block.stencils, block.materials, block.increment, block.force);
  block.report(state);
}

void tangent(benchmark::State& state, const unsigned int law, const double shift)
{
  const Block block(law, shift);
  update_stress_and_force<3>(block.particles.arrays(), block.stencils, block.materials, block.increment, block.force);
  for (auto _ : state)
    add_tangent<3>(block.particles.arrays(), block.stencils, block.materials, block.system->graph(),
                   block.system->values());
  block.report(state);
}

/// One residual and one matrix: what a Newton iteration without line search costs before the linear solver.
void newton_iteration(benchmark::State& state, const unsigned int law, const double shift)
{
  Block block(law, shift);
  for (auto _ : state)
  {
    update_stress_and_force<3>(block.particles.arrays(), block.stencils, block.materials, block.increment, block.force);
    block.system->clear_matrix();
    add_tangent<3>(block.particles.arrays(), block.stencils, block.materials, block.system->graph(),
                   block.system->values());
  }
  block.report(state);
}

/// A time step of explicit dynamics: forces, and nodes that move to and fro.
void time_step(benchmark::State& state, const unsigned int law, const double shift)
{
  const Block block(law, shift);
  const ParticlePath path = begin_path(block.particles.arrays(), 3, block.increment.extent(0) / 3);
  const NodalVector x = block.increment, v = block.system->make_nodal_vector(), f = block.force;
  double sign = 1e-3;
  for (auto _ : state)
  {
    Kokkos::deep_copy(f, 0.);
    advance_stress_and_force<3>(block.particles.arrays(), block.stencils, block.materials, x, path, f);
    sign = -sign;
    const double dt = sign;
    Kokkos::parallel_for(
        "move", Kokkos::RangePolicy<ExecutionSpace>(0, x.extent(0)), KOKKOS_LAMBDA(const std::size_t i) {
          v(i) = 0.5 * v(i) - 1e-12 * f(i);
          x(i) += dt * (x(i) + v(i));
        });
  }
  block.report(state);
}

/// Overlaps and shape functions, once per step.
void stencils(benchmark::State& state, const double shift)
{
  const Block block(law_index<Elastic>, shift);
  for (auto _ : state)
    benchmark::DoNotOptimize(build_stencils<3>(
        block.mesh.leaves(), find_box_parts<3>(block.mesh.leaves(), block.particles.positions(),
                                               block.particles.half_widths(), block.particles.leaves())));
  block.report(state);
}

constexpr double at_rest = 0., moved = 0.1;
} // namespace

#define KEDGE_BENCHMARK(name)                                                                                          \
  BENCHMARK_CAPTURE(name, elastic_8_nodes, law_index<Elastic>, at_rest)->Unit(benchmark::kMillisecond);                \
  BENCHMARK_CAPTURE(name, elastic_27_nodes, law_index<Elastic>, moved)->Unit(benchmark::kMillisecond);                 \
  BENCHMARK_CAPTURE(name, mohr_coulomb_8_nodes, law_index<MohrCoulomb>, at_rest)->Unit(benchmark::kMillisecond);       \
  BENCHMARK_CAPTURE(name, mohr_coulomb_27_nodes, law_index<MohrCoulomb>, moved)->Unit(benchmark::kMillisecond)
KEDGE_BENCHMARK(stress_and_force);
KEDGE_BENCHMARK(time_step);
KEDGE_BENCHMARK(tangent);
KEDGE_BENCHMARK(newton_iteration);
BENCHMARK_CAPTURE(stencils, 8_nodes, at_rest)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stencils, 27_nodes, moved)->Unit(benchmark::kMillisecond);
