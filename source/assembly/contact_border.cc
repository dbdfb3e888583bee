#include <kedge/assembly/contact_border.h>
#include <utility>

namespace kedge
{
Border contact_border(const ContactArrays& contact, const SurfaceMotions& surfaces, const std::vector<RigidRate>& rates,
                      const System& system)
{
  Border border;
  border.columns = Teuchos::rcp(new TpetraMultiVector(system.graph().row_map, rates.size()));
  border.rows = Teuchos::rcp(new TpetraMultiVector(system.graph().row_map, rates.size()));
  for (std::size_t i = 0; i < rates.size(); ++i)
  {
    const NodalVector column = system.make_nodal_vector(), row = system.make_nodal_vector();
    add_contact_coupling(system.graph().dim, contact, surfaces, rates[i].point, rates[i].direction, -1., column, row);
    for (const auto& [local, vectors] : {std::make_pair(column, border.columns), std::make_pair(row, border.rows)})
    {
      const auto owned = vectors->getVectorNonConst(i);
      system.collect(local, *owned);
      system.zero_constrained(*owned);
    }
  }
  return border;
}
} // namespace kedge
