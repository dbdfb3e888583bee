#include <algorithm>
#include <cmath>
#include <kedge/basis/ghost_faces.h>
#include <kedge/basis/gimp.h>
#include <stdexcept>
#include <string>

namespace kedge
{
namespace
{
/// Adds J of the face between a leaf and its neighbour. The face is that of the leaf, which must not be the larger one.
template <int dim>
void add_face(const LeafTable<dim>& table, const unsigned int leaf, const unsigned int neighbour,
              const unsigned int axis, const bool upper, HostGhostFaces& faces)
{
  const auto& cell = table.leaves[leaf];
  const double h = cell.size, area = std::pow(h, dim - 1);
  // Jump of the normal derivative at the Gauss points of the face, for every node of both leaves.
  const unsigned int n_points = 1u << (dim - 1);
  std::vector<unsigned int> nodes;
  std::vector<std::vector<double>> jumps(n_points); // by quadrature point and node
  std::vector<NodeShare<dim>> shares;
  for (unsigned int q = 0; q < n_points; ++q)
  {
    std::array<double, dim> x;
    for (unsigned int d = 0, bit = 0; d < dim; ++d)
      x[d] =
          cell.lower[d] + h * (d == axis ? (upper ? 1. : 0.) : 0.5 + ((q >> bit++) & 1u ? 0.5 : -0.5) / std::sqrt(3.));
    shares.clear();
    add_leaf_shape<dim>(table, leaf, x, -1., shares);
    add_leaf_shape<dim>(table, neighbour, x, 1., shares);
    if (q == 0)
      for (const NodeShare<dim>& share : shares)
        nodes.push_back(share.node);
    for (const NodeShare<dim>& share : shares) // the leaves' nodes have the same order at every point
      jumps[q].push_back(share.gradient[axis]);
  }
  if (nodes.size() > max_ghost_face_nodes)
    throw std::logic_error("a ghost face has " + std::to_string(nodes.size()) + " nodes");
  faces.measure.push_back(h * h * h / 3. * area);
  for (unsigned int a = 0; a < nodes.size(); ++a)
    for (unsigned int b = 0; b < nodes.size(); ++b)
    {
      double sum = 0.;
      for (unsigned int q = 0; q < n_points; ++q)
        sum += jumps[q][a] * jumps[q][b];
      faces.value.push_back(faces.measure.back() / n_points * sum);
    }
  faces.nodes.insert(faces.nodes.end(), nodes.begin(), nodes.end());
  faces.node_begin.push_back(faces.nodes.size());
  faces.value_begin.push_back(faces.value.size());
}
} // namespace

template <int dim>
HostGhostFaces find_ghost_faces(const LeafTable<dim>& table, const std::vector<LeafContent>& contents,
                                const GhostFactors& factors)
{
  HostGhostFaces faces;
  for (unsigned int leaf = 0; leaf < table.leaves.size(); ++leaf)
  {
    if (!table.leaves[leaf].owned || !is_populated(contents[leaf]))
      continue;
    for (unsigned int axis = 0; axis < dim; ++axis)
      for (const bool upper : {false, true})
      {
        const std::vector<unsigned int> neighbours = find_neighbours(table, leaf, axis, upper);
        if (neighbours.size() != 1) // none, or finer ones, which own their faces
          continue;
        // The smaller leaf owns the face; of equal leaves it is the lower one.
        const unsigned int other = neighbours[0];
        const double size = table.leaves[leaf].size, other_size = table.leaves[other].size;
        const bool mine = other_size > 1.5 * size || (other_size > 0.75 * size && upper);
        if (!mine || !is_populated(contents[other]) || contents[leaf].boundary + contents[other].boundary == 0.)
          continue;
        add_face(table, leaf, other, axis, upper, faces);
        const LeafContent &here = contents[leaf], &there = contents[other];
        const double h = std::min(size, other_size);
        faces.stiffness.push_back(0.5 * (factors.stiffness + factors.relative_stiffness / (h * h)) *
                                  (here.stiffness / here.volume + there.stiffness / there.volume));
        faces.mass.push_back(0.5 * factors.mass * (here.mass / here.volume + there.mass / there.volume));
      }
  }
  return faces;
}

GhostFaces upload_ghost_faces(HostGhostFaces&& host, const std::vector<unsigned int>& number)
{
  for (unsigned int& node : host.nodes)
    node = number[node];
  return {upload(host.node_begin, "ghost node begin"),
          upload(host.nodes, "ghost nodes"),
          upload(host.value_begin, "ghost value begin"),
          upload(host.value, "ghost values"),
          upload(host.measure, "ghost measure"),
          upload(host.stiffness, "ghost stiffness"),
          upload(host.mass, "ghost mass")};
}

template HostGhostFaces find_ghost_faces<2>(const LeafTable<2>&, const std::vector<LeafContent>&, const GhostFactors&);
template HostGhostFaces find_ghost_faces<3>(const LeafTable<3>&, const std::vector<LeafContent>&, const GhostFactors&);
} // namespace kedge
