// Loops in which some threads of a GPU share each item, where a thread of a CPU does it alone.
#pragma once

#include <kedge/base/kokkos.h>
#include <string>

namespace kedge
{
using GroupMember = Kokkos::TeamPolicy<ExecutionSpace>::member_type;

/// Calls kernel(group, memory, i) for i in [0, n). In it, parallel_for(ThreadVectorRange(group, count), ...) divides
/// work between the threads of the group and waits for them. `memory` holds `size` numbers of the group.
template <typename Kernel>
void for_each_in_groups(const std::string& label, const std::size_t n, const std::size_t size, const Kernel& kernel)
{
  using Memory = Kokkos::View<double*, ExecutionSpace::scratch_memory_space, Kokkos::MemoryUnmanaged>;
  if (n == 0)
    return;
  constexpr int groups = device_is_host ? 1 : 8, threads = device_is_host ? 1 : 8;
  constexpr std::size_t in_turn = device_is_host ? 64 : 1; // of a group: to begin with a team takes time
  Kokkos::TeamPolicy<ExecutionSpace> policy(static_cast<int>((n + groups * in_turn - 1) / (groups * in_turn)), groups,
                                            threads);
  policy.set_scratch_size(0, Kokkos::PerThread(static_cast<int>(Memory::shmem_size(size))));
  Kokkos::parallel_for(
      label, policy, KOKKOS_LAMBDA(const GroupMember& group) {
        const std::size_t begin = (std::size_t(group.league_rank()) * groups + group.team_rank()) * in_turn;
        const Memory memory(group.thread_scratch(0), size);
        for (std::size_t i = begin; i < begin + in_turn && i < n; ++i)
          kernel(group, memory.data(), static_cast<unsigned int>(i));
      });
}
} // namespace kedge
