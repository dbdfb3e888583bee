#include "domain.h"
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/materials/hencky.h>
#include <kedge/particles/merging.h>
#include <map>

namespace kedge
{
namespace
{
constexpr double width_tolerance = 1.05;
/// Share of the box with a group's second moments that its domains must fill.
constexpr double least_filling = 0.55;

template <int dim> using Particle = typename ParticleSet<dim>::Handler::particle_iterator;
template <int dim> using Group = std::vector<Particle<dim>>;

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// V0 1/2 tau : eps, J.
double elastic_energy(const double* data)
{
  const Eigen::Map<const SymmetricTensor> stress(data + field::stress), strain(data + field::elastic_strain);
  return 0.5 * data[field::initial_volume] *
         (stress.head<3>().dot(strain.head<3>()) + 2. * stress.tail<3>().dot(strain.tail<3>()));
}

/// 1/2 m v^2, J.
double kinetic_energy(const double* data)
{
  return 0.5 * data[field::mass] * Eigen::Map<const Eigen::Vector3d>(data + field::velocity).squaredNorm();
}

template <int dim> double total(const Group<dim>& group, double (*energy)(const double*))
{
  double sum = 0.;
  for (const auto& particle : group)
    sum += energy(particle->get_properties().data());
  return sum;
}

/// The smallest members of a group that are together no wider than `limit`, in an order that does not depend on ranks.
template <int dim> Group<dim> select_smallest(Group<dim> group, const double limit)
{
  const auto volume = [](const Particle<dim>& particle)
  { return domain_volume<dim>(particle->get_properties().data()); };
  // siblings have the same volume but for round-off, which depends on ranks and which float leaves out
  const auto place = [&](const Particle<dim>& particle)
  { return std::make_pair(static_cast<float>(volume(particle)), particle->get_id()); };
  std::sort(group.begin(), group.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  const double largest_sum = std::pow(limit, dim);
  double sum = 0.;
  const auto end = std::find_if(group.begin(), group.end(),
                                [&](const auto& particle) { return (sum += volume(particle)) > largest_sum; });
  group.erase(end, group.end());
  return group;
}

/// What a member of a group counts in the sum over a field; 0 where the field is not a sum.
double weight_of(const FieldRule rule, const double* data)
{
  switch (rule)
  {
    case FieldRule::share:
      return 1.;
    case FieldRule::place:
    case FieldRule::mean_by_mass:
      return data[field::mass];
    case FieldRule::mean_by_volume:
      return data[field::initial_volume];
    case FieldRule::mean_by_stiffness:
      return data[field::initial_volume] * data[field::young];
    case FieldRule::same:
    case FieldRule::width: // join_domains
      break;
  }
  return 0.;
}

struct MergedData
{
  std::array<double, field::count> data{};
  std::array<double, 3> position{}; ///< m
  bool sound = false;               ///< the domain is well filled and F can be scaled
};

/// The box with the second moments of the group's domains, scaled to their volume. The bounding box would be too large
/// by the width of a member where the members are not a lattice. False where the domains fill too little of the box.
template <int dim> bool join_domains(const Group<dim>& group, double* merged)
{
  double volume = 0., box = 1., initial_over_now[dim];
  for (const auto& particle : group)
    volume += domain_volume<dim>(particle->get_properties().data());
  for (unsigned int d = 0; d < dim; ++d)
  {
    double first = 0., second = 0., sum = 0., initial_sum = 0.;
    const double origin = group.front()->get_location()[d];
    for (const auto& particle : group)
    {
      const double *data = particle->get_properties().data(), x = particle->get_location()[d] - origin;
      const double half = data[field::half_width + d], share = domain_volume<dim>(data) / volume;
      first += share * x;
      second += share * (x * x + half * half / 3.);
      sum += data[field::initial_volume] * half;
      initial_sum += data[field::initial_volume] * data[field::initial_half_width + d];
    }
    merged[field::half_width + d] = std::sqrt(3. * (second - first * first));
    initial_over_now[d] = initial_sum / sum;
    box *= 2. * merged[field::half_width + d];
  }
  const double scale = std::pow(volume / box, 1. / dim);
  for (unsigned int d = 0; d < dim; ++d)
  {
    merged[field::half_width + d] *= scale;
    merged[field::initial_half_width + d] = initial_over_now[d] * merged[field::half_width + d];
  }
  return volume >= least_filling * box;
}

/// Scales the mean F to the determinant that keeps the current volume; in plane strain within the plane. False where
/// the group's F differ so much that their mean turns a volume inside out.
template <int dim> bool scale_deformation(double* merged, const double volume_ratio)
{
  Eigen::Map<Matrix> F(merged + field::deformation_gradient);
  const double determinant = F.determinant();
  if (!(determinant > 0.) || !(volume_ratio > 0.))
    return false;
  F.template topLeftCorner<dim, dim>() *= std::pow(volume_ratio / determinant, 1. / dim);
  return true;
}

template <int dim> MergedData join(const Group<dim>& group)
{
  MergedData result;
  double* merged = result.data.data();
  double current_volume = 0., mass = 0., volume = 0., stiffness = 0.;
  for (const auto& particle : group)
  {
    const double* data = particle->get_properties().data();
    mass += data[field::mass];
    volume += data[field::initial_volume];
    stiffness += data[field::initial_volume] * data[field::young];
    for (unsigned int d = 0; d < dim; ++d)
      result.position[d] += data[field::mass] * particle->get_location()[d];
    for_each_field(
        [&](const FieldDeclaration& field, const unsigned int at)
        {
          const double weight = weight_of(field.rule, data);
          for (unsigned int i = at; weight != 0. && i < at + n_components(field.kind); ++i)
            merged[i] += weight * data[i];
        });
    current_volume +=
        data[field::initial_volume] * Eigen::Map<const Matrix>(data + field::deformation_gradient).determinant();
  }
  for (double& x : result.position)
    x /= mass;
  const double* first = group.front()->get_properties().data();
  for_each_field(
      [&](const FieldDeclaration& field, const unsigned int at)
      {
        for (unsigned int i = at; i < at + n_components(field.kind); ++i)
          if (field.rule == FieldRule::same)
            merged[i] = first[i];
          else if (field.rule == FieldRule::place || field.rule == FieldRule::mean_by_mass)
            merged[i] /= mass;
          else if (field.rule == FieldRule::mean_by_volume)
            merged[i] /= volume;
          else if (field.rule == FieldRule::mean_by_stiffness)
            merged[i] /= stiffness;
      });
  const bool filled = join_domains<dim>(group, merged);
  result.sound = scale_deformation<dim>(merged, current_volume / volume) && filled;
  return result;
}

/// The particles of a cell that may be merged with each other, by box of the cell and layer.
template <int dim>
std::vector<Group<dim>> find_groups(ParticleSet<dim>& particles, const typename BackgroundMesh<dim>::Cell& cell,
                                    const unsigned int points_per_axis,
                                    const std::function<bool(const dealii::Point<dim>&)>& keep)
{
  std::map<std::array<unsigned int, dim + 1>, Group<dim>> groups;
  const double box = cell->extent_in_direction(0) / points_per_axis;
  const auto in_cell = particles.handler().particles_in_cell(cell);
  for (auto particle = in_cell.begin(); particle != in_cell.end(); ++particle)
  {
    const double* data = particle->get_properties().data();
    const dealii::Point<dim> x = particle->get_location();
    if (data[field::contact_gap] < domain_width<dim>(data) || keep(x))
      continue;
    std::array<unsigned int, dim + 1> place;
    for (unsigned int d = 0; d < dim; ++d)
      place[d] = static_cast<unsigned int>(std::clamp((x[d] - cell->vertex(0)[d]) / box, 0., points_per_axis - 0.5));
    place[dim] = static_cast<unsigned int>(data[field::layer]);
    groups[place].push_back(particle);
  }
  std::vector<Group<dim>> result;
  for (auto& entry : groups)
  {
    std::sort(entry.second.begin(), entry.second.end(),
              [](const auto& a, const auto& b) { return a->get_id() < b->get_id(); });
    if (Group<dim> group = select_smallest<dim>(entry.second, width_tolerance * box); group.size() > 1)
      result.push_back(std::move(group));
  }
  return result;
}

/// What cannot be joined as a whole may be in parts: adds those of a group on either side of its middle along all axes.
template <int dim> void halve(const Group<dim>& group, std::vector<Group<dim>>& parts)
{
  if (group.size() <= (1U << dim)) // siblings of a split are joined together or not at all
    return;
  dealii::Point<dim> middle;
  for (const auto& particle : group)
    middle += particle->get_location() / static_cast<double>(group.size());
  std::array<Group<dim>, (1U << dim)> part;
  for (const auto& particle : group)
  {
    unsigned int side = 0;
    for (unsigned int d = 0; d < dim; ++d)
      side += particle->get_location()[d] > middle[d] ? 1U << d : 0U;
    part[side].push_back(particle);
  }
  for (Group<dim>& members : part)
    if (members.size() > 1 && members.size() < group.size())
      parts.push_back(std::move(members));
}

/// Puts the merged particle in the place of the member with the smallest number; returns the other members.
template <int dim>
Group<dim> replace(const Group<dim>& group, const MergedData& merged, const BackgroundMesh<dim>& mesh,
                   const typename BackgroundMesh<dim>::Cell& cell)
{
  Group<dim> others = group;
  const auto first = std::min_element(others.begin(), others.end(),
                                      [](const auto& a, const auto& b) { return a->get_id() < b->get_id(); });
  Particle<dim> particle = *first;
  others.erase(first);
  dealii::Point<dim> x;
  for (unsigned int d = 0; d < dim; ++d)
    x[d] = merged.position[d];
  particle->set_location(x);
  particle->set_reference_location(mesh.mapping().transform_real_to_unit_cell(cell, x));
  std::copy(merged.data.begin(), merged.data.end(), particle->get_properties().begin());
  return others;
}
} // namespace

template <int dim>
MergeResult merge_particles(ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh,
                            const unsigned int points_per_axis,
                            const std::function<bool(const dealii::Point<dim>&)>& keep, const double energy_tolerance)
{
  MergeResult result;
  auto& handler = particles.edit();
  Group<dim> doomed;
  const unsigned int needed =
      dim == 3 ? points_per_axis * points_per_axis * points_per_axis : points_per_axis * points_per_axis;
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
  {
    if (!cell->is_locally_owned() || handler.n_particles_in_cell(cell) <= needed)
      continue;
    std::vector<Group<dim>> groups = find_groups<dim>(particles, cell, points_per_axis, keep);
    while (!groups.empty())
    {
      const Group<dim> group = std::move(groups.back());
      groups.pop_back();
      const MergedData merged = join<dim>(group);
      const double before = total<dim>(group, elastic_energy), lost = before - elastic_energy(merged.data.data());
      const double motion = total<dim>(group, kinetic_energy), stopped = motion - kinetic_energy(merged.data.data());
      // of soil at rest the motion is noise, which is better lost: it counts beside the elastic energy
      if (!merged.sound || lost > energy_tolerance * before || stopped > energy_tolerance * (before + motion))
      {
        halve<dim>(group, groups);
        continue;
      }
      const Group<dim> others = replace<dim>(group, merged, mesh, cell);
      doomed.insert(doomed.end(), others.begin(), others.end());
      result.elastic_energy_lost += lost;
      result.elastic_energy_merged += before;
    }
  }
  const MPI_Comm communicator = mesh.communicator();
  result.removed = sum_over_ranks(static_cast<long long>(doomed.size()), communicator);
  result.elastic_energy_lost = sum_over_ranks(result.elastic_energy_lost, communicator);
  result.elastic_energy_merged = sum_over_ranks(result.elastic_energy_merged, communicator);
  if (result.removed > 0)
    handler.remove_particles(doomed);
  return result;
}

template MergeResult merge_particles<2>(ParticleSet<2>&, const BackgroundMesh<2>&, unsigned int,
                                        const std::function<bool(const dealii::Point<2>&)>&, double);
template MergeResult merge_particles<3>(ParticleSet<3>&, const BackgroundMesh<3>&, unsigned int,
                                        const std::function<bool(const dealii::Point<3>&)>&, double);
} // namespace kedge
