// The committed history of the pairs: what a step leaves to the next one, from rank to rank and through restart files.
#include <algorithm>
#include <iterator>
#include <kedge/base/communication.h>
#include <kedge/contact/contact.h>
#include <unordered_map>
#include <unordered_set>

namespace kedge
{
namespace
{
/// The records of the particles that have arrived here. Nobody knows where a particle has gone, so records and arrivals
/// meet on the rank that the particle's number gives. Collective.
std::vector<ContactRecord> deliver(const std::vector<ContactRecord>& leaving, const std::vector<long long>& arrived,
                                   const MPI_Comm communicator)
{
  const int n_ranks = size_of(communicator);
  std::vector<std::vector<ContactRecord>> records(n_ranks);
  for (const ContactRecord& record : leaving)
    records[record.particle % n_ranks].push_back(record);
  std::vector<std::vector<long long>> arrivals(n_ranks);
  for (const long long id : arrived)
    arrivals[id % n_ranks].push_back(id);

  std::unordered_map<long long, int> rank_of_particle;
  const std::vector<std::vector<long long>> noted = exchange_between_ranks(arrivals, communicator);
  for (int r = 0; r < n_ranks; ++r)
    for (const long long id : noted[r])
      rank_of_particle.emplace(id, r);
  std::vector<std::vector<ContactRecord>> forward(n_ranks);
  for (const auto& part : exchange_between_ranks(records, communicator))
    for (const ContactRecord& record : part)
      if (const auto found = rank_of_particle.find(record.particle); found != rank_of_particle.end())
        forward[found->second].push_back(record); // the particles of others are gone
  std::vector<ContactRecord> result;
  for (const auto& part : exchange_between_ranks(forward, communicator))
    result.insert(result.end(), part.begin(), part.end());
  return result;
}
} // namespace

template <int dim> void Contact<dim>::commit()
{
  history = waiting;
  const auto host = pairs.read_on_host();
  for (std::size_t k = 0; k < n_pairs; ++k)
    if (host(k).active || host(k).trial.reference_gap != 0.)
      history[host(k).key] = host(k).trial;
}

template <int dim> std::vector<bool> Contact<dim>::points_that_press(const RigidSystems& bodies) const
{
  std::vector<double> here(bodies.points.size(), 0.);
  for (const auto& [key, state] : history)
    if (state.pressure > 0. || state.bonded)
      here[bodies.surfaces[key.surface].point] = 1.;
  std::vector<bool> result;
  for (const double presses : here)
    result.push_back(max_over_ranks(presses, communicator) > 0.);
  return result;
}

template <int dim> void Contact<dim>::follow_particles(const std::vector<long long>& ids)
{
  std::unordered_set<long long> touched, here;
  for (const auto& entry : history)
    touched.insert(entry.first.particle);
  for (const long long id : ids)
    if (touched.count(id))
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
  if (size_of(communicator) == 1)
    return;
  if (max_over_ranks(!leaving.empty(), communicator) > 0.)
  {
    const std::unordered_set<long long> known(known_ids.begin(), known_ids.end());
    std::vector<long long> arrived;
    std::copy_if(ids.begin(), ids.end(), std::back_inserter(arrived),
                 [&](const long long id) { return known.count(id) == 0; });
    for (const ContactRecord& record : deliver(leaving, arrived, communicator))
      enter(record);
  }
  known_ids = ids;
}

template <int dim> ContactRecord Contact<dim>::to_record(const ContactKey& key, const ContactHistory& state)
{
  const Eigen::Vector3d& t = state.tangential;
  return {key.particle,     key.corner,   key.surface,    {t[0], t[1], t[2]}, state.reference_gap,
          state.multiplier, state.bonded, state.pressure, state.memory};
}

template <int dim> void Contact<dim>::enter(const ContactRecord& record)
{
  ContactHistory& state = history[{record.particle, record.corner, record.surface}];
  state.tangential = Eigen::Map<const Eigen::Vector3d>(record.tangential);
  state.reference_gap = record.reference_gap;
  state.multiplier = record.multiplier;
  state.bonded = record.bonded != 0;
  state.pressure = record.pressure;
  state.memory = record.memory;
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
  known_ids.clear();
  for (const ContactRecord& record : records)
    enter(record);
  follow_particles(ids);
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void Contact<dim>::commit();                                                                                \
  template std::vector<bool> Contact<dim>::points_that_press(const RigidSystems&) const;                               \
  template void Contact<dim>::follow_particles(const std::vector<long long>&);                                         \
  template std::vector<ContactRecord> Contact<dim>::export_history() const;                                            \
  template void Contact<dim>::import_history(const std::vector<ContactRecord>&, const std::vector<long long>&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
