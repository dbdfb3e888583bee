#include "domain.h"
#include "stress_slope.h"
#include <Eigen/LU>
#include <algorithm>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/particles/splitting.h>
#include <limits>
#include <map>
#include <numeric>

namespace kedge
{
namespace
{
/// How far inside the grid a centre must lie, in base cells: more than the round-off by which cells find their points.
constexpr double margin = 1e-9;

/// A particle that is between cells.
template <int dim> struct Piece
{
  std::array<double, dim> position; ///< m
  long long id;
  int origin; ///< rank that held the particle it was a part of
  std::array<double, field::count> data;
  std::array<double, 6 * dim> slope; ///< of the stress, as StressSlope
};

/// Makes the values of a field of a particle those of one of its `n` children. It is cut along `axes`, by bits.
void divide_field(const FieldDeclaration& field, double* value, const std::size_t n, const Eigen::Vector3d& offset,
                  const unsigned int axes)
{
  for (unsigned int i = 0; i < n_components(field.kind); ++i)
    switch (field.rule)
    {
      case FieldRule::share:
        value[i] /= n;
        break;
      case FieldRule::width:
        value[i] *= (axes >> i) & 1u ? 0.5 : 1.;
        break;
      case FieldRule::place:
        value[i] += offset[i];
        break;
      case FieldRule::same:
      case FieldRule::mean_by_mass:
      case FieldRule::mean_by_volume:
      case FieldRule::mean_by_stiffness:
        break;
    }
}

/// By octant; those that lack an axis of the cut in their number are the same as others, and do not count.
template <int dim>
std::array<Piece<dim>, 1u << dim> cut_in_octants(const Piece<dim>& parent, const Split<dim>& split,
                                                 const GridLayout<dim>& grid, const Material* const material)
{
  using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::Matrix3d to_initial =
      Eigen::Map<const Matrix>(parent.data.data() + field::deformation_gradient).inverse();
  const double inset = margin * grid.base_size;
  std::array<Piece<dim>, 1u << dim> children;
  for (unsigned int octant = 0; octant < children.size(); ++octant)
  {
    Piece<dim>& child = children[octant];
    child = parent;
    child.id = split.children[octant];
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    for (unsigned int d = 0; d < dim; ++d)
    {
      if (!split.is_cut_along(d))
        continue;
      offset[d] = ((octant >> d) & 1u ? 0.5 : -0.5) * parent.data[field::half_width + d];
      child.position[d] = std::clamp(parent.position[d] + offset[d], inset, grid.extent(d) - inset);
    }
    const Eigen::Vector3d initial_offset = to_initial * offset;
    for_each_field([&](const FieldDeclaration& field, const unsigned int at)
                   { divide_field(field, &child.data[at], split.n_children(), initial_offset, split.axes); });
    if (material != nullptr)
      add_slope<dim>(Eigen::Map<const StressSlope<dim>>(parent.slope.data()), offset, *material, child.data.data());
  }
  return children;
}

/// Width over cell size up to which a particle fits: midway, in steps of halving, between one that fits and one that is
/// twice as wide.
double widest(const unsigned int points_per_axis) { return std::sqrt(2.) / points_per_axis; }

/// Places of different numbers below `end` in the sorted list of those of all ranks. Each rank sorts a range of them.
/// Collective.
std::vector<long long> places_among_all(const std::vector<long long>& numbers, const long long end,
                                        const MPI_Comm communicator)
{
  const long long n_ranks = size_of(communicator), range = end / n_ranks + 1;
  std::vector<std::vector<long long>> asked(n_ranks);
  for (const long long number : numbers)
    asked[number / range].push_back(number);
  std::vector<std::vector<long long>> questions = exchange_between_ranks(asked, communicator);
  std::vector<long long> sorted;
  for (const auto& part : questions)
    sorted.insert(sorted.end(), part.begin(), part.end());
  std::sort(sorted.begin(), sorted.end());
  const long long before = sum_over_lower_ranks(static_cast<long long>(sorted.size()), communicator);
  for (auto& part : questions)
    for (long long& number : part)
      number = before + (std::lower_bound(sorted.begin(), sorted.end(), number) - sorted.begin());
  const std::vector<std::vector<long long>> answers = exchange_between_ranks(questions, communicator);
  std::vector<std::size_t> next(n_ranks, 0);
  std::vector<long long> places;
  for (const long long number : numbers)
    places.push_back(answers[number / range][next[number / range]++]);
  return places;
}

/// The splitting of all particles of all ranks, generation by generation.
template <int dim> class Splitting
{
public:
  Splitting(ParticleSet<dim>& particles_, const BackgroundMesh<dim>& mesh_, const unsigned int points_per_axis,
            const std::optional<FormerCells<dim>>& former_)
      : particles(particles_.edit()),
        mesh(mesh_),
        former(former_),
        communicator(mesh.communicator()),
        limit(widest(points_per_axis)),
        next_number(particles.get_next_free_particle_index())
  {
  }

  std::vector<Split<dim>> run()
  {
    const auto wide = find_wide_particles();
    if (!any_waiting())
      return {};
    find_slopes();
    particles.remove_particles(wide);
    while (any_waiting())
      split_generation();
    for (const Piece<dim>& piece : fitting)
      insert(piece);
    particles.update_cached_numbers();
    return std::move(splits);
  }

private:
  using Handler = typename ParticleSet<dim>::Handler;
  static constexpr unsigned int n_children = 1u << dim;

  bool any_waiting() const { return sum_over_ranks(static_cast<long long>(waiting.size()), communicator) > 0; }

  bool fits(const double* data, const double cell_size) const
  {
    return axes_wider_than<dim>(data, limit * cell_size) == 0;
  }

  /// Copies the particles that are too wide for their cells to `waiting`; returns where they are.
  std::vector<typename Handler::particle_iterator> find_wide_particles()
  {
    std::vector<typename Handler::particle_iterator> wide;
    for (const auto& cell : mesh.triangulation().active_cell_iterators())
    {
      if (!cell->is_locally_owned())
        continue;
      const auto in_cell = particles.particles_in_cell(cell);
      for (auto particle = in_cell.begin(); particle != in_cell.end(); ++particle)
      {
        const double* data = particle->get_properties().data();
        if (fits(data, cell->extent_in_direction(0)))
          continue;
        Piece<dim> piece;
        piece.position = to_array<dim>(particle->get_location());
        piece.slope.fill(0.);
        piece.id = particle->get_id();
        piece.origin = rank_of(communicator);
        std::copy_n(data, piece.data.size(), piece.data.begin());
        waiting.push_back(piece);
        wide.push_back(particle);
      }
    }
    return wide;
  }

  /// Of the stress around the particles of cells that have just been refined, whose parts this rank holds all, each
  /// layer by itself. Others find no slope: what lies around them may be on other ranks.
  void find_slopes()
  {
    if (!former)
      return;
    materials = copy_to_host(former->materials);
    std::map<std::pair<int, unsigned int>, StressFit<dim>> fits;
    for (const auto& cell : mesh.triangulation().active_cell_iterators())
    {
      if (!cell->is_locally_owned())
        continue;
      const int whole = refined_cell(to_array<dim>(cell->center()), cell->extent_in_direction(0));
      if (whole >= 0)
        for (const auto& particle : particles.particles_in_cell(cell))
          fits[{whole, layer_of(particle.get_properties().data())}].add(to_array<dim>(particle.get_location()),
                                                                        particle.get_properties().data());
    }
    for (Piece<dim>& piece : waiting)
    {
      const double size = mesh.leaves().leaves[mesh.leaves().find_leaf(piece.position)].size;
      const auto fit = fits.find({refined_cell(piece.position, size), layer_of(piece.data.data())});
      if (fit == fits.end())
        continue;
      Eigen::Map<StressSlope<dim>> slope(piece.slope.data());
      slope = fit->second.slope(2. * size);
      const Eigen::Map<const Eigen::Vector3d> half_width(&piece.data[field::half_width]);
      slope *= bearable_share<dim>(slope, 0.5 * half_width, *material_of(piece), size, piece.data.data());
    }
  }

  /// Number of the former cell that holds a point, if it was larger than the one that holds it now; otherwise -1.
  int refined_cell(const std::array<double, dim>& x, const double size) const
  {
    const int leaf = former->leaves.find_leaf(x);
    return leaf >= 0 && former->leaves.leaves[leaf].size > 1.5 * size ? leaf : -1;
  }

  static unsigned int layer_of(const double* data) { return static_cast<unsigned int>(data[field::layer]); }

  const Material* material_of(const Piece<dim>& piece) const
  {
    return former ? &materials(layer_of(piece.data.data())) : nullptr;
  }

  void split_generation()
  {
    const std::vector<Piece<dim>> parents = std::move(waiting);
    waiting.clear();
    std::vector<long long> numbers;
    for (const Piece<dim>& parent : parents)
      numbers.push_back(parent.id);
    const std::vector<long long> places = places_among_all(numbers, next_number, communicator);
    const long long n_parents = sum_over_ranks(static_cast<long long>(parents.size()), communicator);

    std::vector<std::vector<Piece<dim>>> strays(size_of(communicator));
    std::vector<std::vector<Split<dim>>> by_origin(size_of(communicator));
    for (std::size_t i = 0; i < parents.size(); ++i)
    {
      const Piece<dim>& parent = parents[i];
      const double size = mesh.leaves().leaves[mesh.leaves().find_leaf(parent.position)].size;
      Split<dim> split{parent.id, {{parent.id}}, parent.position, {}, {}};
      split.axes = axes_wider_than<dim>(parent.data.data(), limit * size);
      std::copy_n(&parent.data[field::half_width], dim, split.half_width.begin());
      std::iota(split.children.begin() + 1, split.children.end(), next_number + (n_children - 1) * places[i]);
      by_origin[parent.origin].push_back(split);
      const auto children = cut_in_octants<dim>(parent, split, mesh.layout(), material_of(parent));
      for (unsigned int octant = 0; octant < children.size(); ++octant)
        if (split.has_child(octant) && !take_if_owned(children[octant]))
          strays[mesh.leaves().find_owner(children[octant].position)].push_back(children[octant]);
    }
    next_number += (n_children - 1) * n_parents;
    if (next_number > std::numeric_limits<dealii::types::particle_index>::max())
      throw SolverError("splitting has used up the numbers of material points; choose a coarser mesh at the bodies");

    for (const auto& part : exchange_between_ranks(strays, communicator))
      for (const Piece<dim>& stray : part)
        take_if_owned(stray);
    for (const auto& part : exchange_between_ranks(by_origin, communicator))
      splits.insert(splits.end(), part.begin(), part.end());
  }

  bool take_if_owned(const Piece<dim>& piece)
  {
    const int leaf = mesh.leaves().find_leaf(piece.position);
    if (leaf < 0 || !mesh.leaves().leaves[leaf].owned)
      return false;
    (fits(piece.data.data(), mesh.leaves().leaves[leaf].size) ? fitting : waiting).push_back(piece);
    return true;
  }

  void insert(const Piece<dim>& piece)
  {
    const auto& leaf = mesh.leaves().leaves[mesh.leaves().find_leaf(piece.position)];
    const typename BackgroundMesh<dim>::Cell cell(&mesh.triangulation(), leaf.tree_level, leaf.tree_index);
    dealii::Point<dim> x;
    for (unsigned int d = 0; d < dim; ++d)
      x[d] = piece.position[d];
    particles.insert_particle(x, mesh.mapping().transform_real_to_unit_cell(cell, x), piece.id, cell,
                              dealii::ArrayView<const double>(piece.data.data(), piece.data.size()));
  }

  Handler& particles;
  const BackgroundMesh<dim>& mesh;
  const std::optional<FormerCells<dim>>& former;
  Materials::HostMirror materials; ///< of the layers, where there are former cells
  MPI_Comm communicator;
  double limit; ///< width over cell size up to which a particle fits
  long long next_number;
  std::vector<Piece<dim>> waiting, fitting;
  std::vector<Split<dim>> splits;
};
} // namespace

template <int dim>
bool any_too_wide(const ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh,
                  const unsigned int points_per_axis)
{
  bool found = false;
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
  {
    if (!cell->is_locally_owned() || found)
      continue;
    const double limit = widest(points_per_axis) * cell->extent_in_direction(0);
    for (const auto& particle : particles.handler().particles_in_cell(cell))
      found = found || axes_wider_than<dim>(particle.get_properties().data(), limit) != 0;
  }
  return sum_over_ranks(static_cast<long long>(found), mesh.communicator()) > 0;
}

template <int dim>
std::vector<Split<dim>> split_particles(ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh,
                                        const unsigned int points_per_axis,
                                        const std::optional<FormerCells<dim>>& former)
{
  return Splitting<dim>(particles, mesh, points_per_axis, former).run();
}

template bool any_too_wide<2>(const ParticleSet<2>&, const BackgroundMesh<2>&, unsigned int);
template bool any_too_wide<3>(const ParticleSet<3>&, const BackgroundMesh<3>&, unsigned int);
template std::vector<Split<2>> split_particles<2>(ParticleSet<2>&, const BackgroundMesh<2>&, unsigned int,
                                                  const std::optional<FormerCells<2>>&);
template std::vector<Split<3>> split_particles<3>(ParticleSet<3>&, const BackgroundMesh<3>&, unsigned int,
                                                  const std::optional<FormerCells<3>>&);
} // namespace kedge
