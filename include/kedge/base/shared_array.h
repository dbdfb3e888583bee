// Arrays that host and device change in turns.
#pragma once

#include <kedge/base/kokkos.h>

namespace kedge
{
/// Whoever asks for the array gets its newest values. Where host and device share their storage nothing is copied; else
/// it is when the other one asks next. Copies share the array as views do, but not what is known of it: there should be
/// one.
template <typename T> class SharedArray
{
public:
  SharedArray() = default;
  /// Of n entries that nobody has set.
  SharedArray(const std::string& label, const std::size_t n)
      : device(Kokkos::view_alloc(label, Kokkos::WithoutInitializing), n), host(make_mirror(device))
  {
  }

  std::size_t size() const { return device.extent(0); }

  /// To be read and written there.
  View<T*> on_device()
  {
    read_on_device();
    newest = Newest::on_device;
    return device;
  }
  HostView<T*> on_host()
  {
    read_on_host();
    return overwrite_on_host();
  }
  /// To be written there: it may hold old values.
  HostView<T*> overwrite_on_host()
  {
    newest = Newest::on_host;
    return host;
  }

  /// Only to be read.
  View<T*> read_on_device() const
  {
    if (newest == Newest::on_host)
      Kokkos::deep_copy(device, host);
    newest = newest == Newest::on_host ? Newest::on_both : newest;
    return device;
  }
  typename HostView<T*>::const_type read_on_host() const
  {
    if (newest == Newest::on_device)
      Kokkos::deep_copy(host, device);
    newest = newest == Newest::on_device ? Newest::on_both : newest;
    return host;
  }

private:
  enum class Newest
  {
    on_both,
    on_host,
    on_device
  };
  View<T*> device;
  HostView<T*> host;
  mutable Newest newest = Newest::on_both;
};
} // namespace kedge
