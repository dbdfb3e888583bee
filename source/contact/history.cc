// The committed history of the pairs: what a step leaves to the next one, from rank to rank and through restart files.
#include <kedge/base/communication.h>
#include <kedge/contact/contact.h>
#include <unordered_set>

namespace kedge
{
template <int dim> void Contact<dim>::commit()
{
  history = waiting;
  for (const Pair& pair : pairs)
    if (pair.active || pair.trial.reference_gap < 0.)
      history[pair.key] = pair.trial;
}

template <int dim> void Contact<dim>::follow_particles(const std::vector<long long>& ids)
{
  std::unordered_set<long long> touched, here;
  for (const auto& entry : history)
    touched.insert(entry.first.particle);
  for (const long long id : ids)
    if (size_of(communicator) > 1 || touched.count(id))
      here.insert(id);
  std::vector<ContactRecord> leaving;
  for (auto entry = history.begin(); entry != history.end();)
    if (here.count(entry->first.particle))
      ++entry;
    else
    {
      leaving.push_back(to_record(entry->first, entry->second));
      entry = history.erase(entry);
    }
  for (const ContactRecord& record : gather_everywhere(leaving, communicator))
    if (here.count(record.particle))
      enter(record);
}

template <int dim> ContactRecord Contact<dim>::to_record(const Key& key, const History& state)
{
  const Eigen::Vector3d& t = state.tangential;
  return {key.particle,        key.corner,       key.surface,  {t[0], t[1], t[2]},
          state.reference_gap, state.multiplier, state.bonded, state.pressure};
}

template <int dim> void Contact<dim>::enter(const ContactRecord& record)
{
  History& state = history[{record.particle, record.corner, record.surface}];
  state.tangential = Eigen::Map<const Eigen::Vector3d>(record.tangential);
  state.reference_gap = record.reference_gap;
  state.multiplier = record.multiplier;
  state.bonded = record.bonded != 0;
  state.pressure = record.pressure;
}

template <int dim> std::vector<ContactRecord> Contact<dim>::export_history() const
{
  std::vector<ContactRecord> records;
  for (const auto& [key, state] : history)
    records.push_back(to_record(key, state));
  return records;
}

template <int dim>
void Contact<dim>::import_history(const std::vector<ContactRecord>& records, const std::vector<long long>& ids)
{
  history.clear();
  for (const ContactRecord& record : records)
    enter(record);
  follow_particles(ids);
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void Contact<dim>::commit();                                                                                \
  template void Contact<dim>::follow_particles(const std::vector<long long>&);                                         \
  template std::vector<ContactRecord> Contact<dim>::export_history() const;                                            \
  template void Contact<dim>::import_history(const std::vector<ContactRecord>&, const std::vector<long long>&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
