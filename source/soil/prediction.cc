#include <kedge/basis/gimp.h>
#include <kedge/soil/prediction.h>

namespace kedge
{
template <int dim>
Prediction transfer_prediction(const Prediction& prediction, const LeafTable<dim>& from, const LeafTable<dim>& to)
{
  if (prediction.empty())
    return {};
  Prediction result(dim * to.node_position.size(), 0.);
  std::vector<NodeShare<dim>> shares;
  for (std::size_t node = 0; node < to.node_position.size(); ++node)
    if (const int leaf = from.find_leaf(to.node_position[node]); leaf >= 0)
    {
      shares.clear();
      add_leaf_shape<dim>(from, leaf, to.node_position[node], 1., shares);
      for (const NodeShare<dim>& share : shares)
        for (unsigned int d = 0; d < dim; ++d)
          result[dim * node + d] += share.value * prediction[dim * share.node + d];
    }
  return result;
}

template Prediction transfer_prediction<2>(const Prediction&, const LeafTable<2>&, const LeafTable<2>&);
template Prediction transfer_prediction<3>(const Prediction&, const LeafTable<3>&, const LeafTable<3>&);
} // namespace kedge
