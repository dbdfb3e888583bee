// Soil in random cells, and the stabilised faces, found by a literal reading of their definition.
#pragma once

#include "../mesh/refined_mesh.h"
#include <Eigen/Dense>
#include <algorithm>
#include <functional>
#include <kedge/basis/ghost_faces.h>
#include <kedge/basis/gimp.h>

namespace kedge::test
{
constexpr double poor_factor = 0.25;
constexpr GhostFactors factors{0.03, 0.2};
constexpr double hair = 1e-9; // m, below any cell

enum class Fill
{
  empty,
  poor,
  full
};

/// One box in each leaf that is not empty.
template <int dim> struct Soil
{
  std::vector<std::array<double, dim>> centre, half_width;
  std::vector<double> young, mass, initial_volume;
};

template <int dim> using Leaf = typename LeafTable<dim>::Leaf;
template <int dim> using FillOf = std::function<Fill(const Leaf<dim>&)>;

template <int dim> Fill random_fill(const Leaf<dim>& leaf)
{
  const double number = noise_at(leaf.lower, dim, 21);
  return number < 0.25 ? Fill::empty : number < 0.4 ? Fill::poor : Fill::full;
}

template <int dim> double young_of(const Leaf<dim>& leaf) { return 1e6 * (1. + noise_at(leaf.lower, dim, 22)); }
template <int dim> double density_of(const Leaf<dim>& leaf) { return 2e3 * (1. + noise_at(leaf.lower, dim, 23)); }

template <int dim> Soil<dim> make_soil(const LeafTable<dim>& table, const FillOf<dim>& fill)
{
  Soil<dim> soil;
  for (const auto& leaf : table.leaves)
  {
    if (!leaf.owned || fill(leaf) == Fill::empty)
      continue;
    const double half = leaf.size * (fill(leaf) == Fill::poor ? 0.2 : 0.49);
    soil.half_width.emplace_back().fill(half);
    soil.centre.push_back(leaf.lower);
    for (double& x : soil.centre.back())
      x += 0.5 * leaf.size;
    soil.young.push_back(young_of<dim>(leaf));
    soil.mass.push_back(density_of<dim>(leaf) * std::pow(2. * half, dim));
    soil.initial_volume.push_back(0.8 * std::pow(2. * half, dim)); // it has swollen
  }
  return soil;
}

template <int dim>
std::vector<LeafContent> find_contents(const LeafTable<dim>& table, const Soil<dim>& soil, const double poor)
{
  return find_leaf_contents<dim>(table,
                                 {find_box_parts<dim>(table, soil.centre, soil.half_width), soil.half_width, soil.young,
                                  soil.mass, soil.initial_volume},
                                 poor, MPI_COMM_WORLD);
}

template <int dim>
HostGhostFaces find_faces(const LeafTable<dim>& table, const FillOf<dim>& fill, const double poor = poor_factor)
{
  return find_ghost_faces<dim>(table, find_contents(table, make_soil(table, fill), poor), factors);
}

using Matrix = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

inline Matrix matrix_of(const HostGhostFaces& faces, const std::size_t f)
{
  const unsigned int n = faces.node_begin[f + 1] - faces.node_begin[f];
  return Matrix(&faces.value[faces.value_begin[f]], n, n);
}

/// A field at the nodes of a face.
template <int dim, typename Field>
Eigen::VectorXd at_nodes(const LeafTable<dim>& table, const HostGhostFaces& faces, const std::size_t f, const Field& u)
{
  Eigen::VectorXd values(faces.node_begin[f + 1] - faces.node_begin[f]);
  for (Eigen::Index i = 0; i < values.size(); ++i)
    values[i] = u(table.node_position[faces.nodes[faces.node_begin[f] + i]]);
  return values;
}

/// Sum over the faces of all ranks of weight u.J u.
template <int dim, typename Field>
double energy(const LeafTable<dim>& table, const HostGhostFaces& faces, const std::vector<double>& weight,
              const Field& u)
{
  double sum = 0.;
  for (std::size_t f = 0; f < weight.size(); ++f)
  {
    const Eigen::VectorXd values = at_nodes(table, faces, f, u);
    sum += weight[f] * values.dot(matrix_of(faces, f) * values);
  }
  return sum_over_ranks(sum, MPI_COMM_WORLD);
}

/// The literal definition, leaf by leaf, on a mesh that is this rank's alone.
template <int dim> class Reference
{
public:
  struct Face
  {
    const Leaf<dim>*lower, *upper; ///< the leaves on both sides
    unsigned int axis;
    const Leaf<dim>& smaller() const { return lower->size < upper->size ? *lower : *upper; }
  };

  const LeafTable<dim>& table() const { return serial.mesh.leaves(); }

  std::vector<Face> stabilised() const
  {
    std::vector<Face> all, chosen;
    for (const auto& lower : table().leaves)
      for (const auto& upper : table().leaves)
        for (unsigned int axis = 0; axis < dim; ++axis)
          if (share_a_face(lower, upper, axis))
            all.push_back({&lower, &upper, axis});
    std::vector<const Leaf<dim>*> beside_empty;
    for (const Face& face : all)
      for (const bool turned : {false, true})
        if (random_fill<dim>(*(turned ? face.upper : face.lower)) == Fill::empty)
          beside_empty.push_back(turned ? face.lower : face.upper);
    const auto is_boundary = [&](const Leaf<dim>* leaf)
    {
      return random_fill<dim>(*leaf) == Fill::poor ||
             std::find(beside_empty.begin(), beside_empty.end(), leaf) != beside_empty.end();
    };
    for (const Face& face : all)
      if (random_fill<dim>(*face.lower) != Fill::empty && random_fill<dim>(*face.upper) != Fill::empty)
        if (is_boundary(face.lower) || is_boundary(face.upper))
          chosen.push_back(face);
    return chosen;
  }

  /// Integral over the face of h^3 / 3 times the square of the jump of the normal derivative, with 3 points per axis
  /// and derivatives from differences across the leaves.
  template <typename Field> double jump_energy(const Face& face, const Field& u) const
  {
    constexpr std::array<double, 3> point{-0.7745966692414834, 0., 0.7745966692414834};
    constexpr std::array<double, 3> weight{5. / 18., 8. / 18., 5. / 18.};
    const Leaf<dim>& cell = face.smaller();
    double sum = 0.;
    for (unsigned int q = 0; q < (dim == 2 ? 3 : 9); ++q)
    {
      std::array<double, dim> x;
      double w = 1.;
      for (unsigned int d = 0, digit = q; d < dim; ++d)
      {
        if (d == face.axis)
          continue;
        x[d] = cell.lower[d] + 0.5 * cell.size * (1. + point[digit % 3]);
        w *= weight[digit % 3] * cell.size;
        digit /= 3;
      }
      const double jump = slope(*face.upper, x, face.axis, u) - slope(*face.lower, x, face.axis, u);
      sum += w * jump * jump;
    }
    return std::pow(cell.size, 3) / 3. * sum;
  }

private:
  static bool share_a_face(const Leaf<dim>& lower, const Leaf<dim>& upper, const unsigned int axis)
  {
    bool shared = std::abs(lower.lower[axis] + lower.size - upper.lower[axis]) < hair;
    for (unsigned int d = 0; d < dim; ++d)
      if (d != axis)
        shared = shared && std::min(lower.lower[d] + lower.size, upper.lower[d] + upper.size) -
                                   std::max(lower.lower[d], upper.lower[d]) >
                               hair;
    return shared;
  }

  template <typename Field>
  double slope(const Leaf<dim>& leaf, std::array<double, dim> x, const unsigned int axis, const Field& u) const
  {
    std::vector<NodeShare<dim>> shares;
    for (const bool end : {false, true})
    {
      x[axis] = leaf.lower[axis] + (end ? leaf.size : 0.);
      add_leaf_shape<dim>(table(), &leaf - table().leaves.data(), x, (end ? 1. : -1.) / leaf.size, shares);
    }
    double sum = 0.;
    for (const NodeShare<dim>& share : shares)
      sum += share.value * u(table().node_position[share.node]);
    return sum;
  }

  RefinedMesh<dim> serial{MPI_COMM_SELF};
};
} // namespace kedge::test
