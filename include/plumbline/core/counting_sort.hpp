#pragma once
/// Items by their key in linear time, without heap; those of the same key stay in their order.

#include <cstddef>

namespace plumbline {

/// out[...] = item(n) of all n < items, by key(n) in [0, keys). begin[k] becomes the first place of key k,
/// begin[keys] = items.
template <class Begin, class Out>
void counting_sort(int items, int keys, Begin& begin, auto&& key, auto&& item, Out& out) {
  for (int k = 0; k <= keys; ++k) begin[std::size_t(k)] = 0;
  for (int n = 0; n < items; ++n) ++begin[std::size_t(key(n)) + 1];
  for (int k = 0; k < keys; ++k) begin[std::size_t(k) + 1] += begin[std::size_t(k)];
  for (int n = 0; n < items; ++n) out[std::size_t(begin[std::size_t(key(n))]++)] = item(n);
  for (int k = keys; k > 0; --k) begin[std::size_t(k)] = begin[std::size_t(k) - 1];
  begin[0] = 0;
}

}  // namespace plumbline
