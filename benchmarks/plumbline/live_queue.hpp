#pragma once
/// Samples of a stream on their way to the estimator.

#include <optional>

#include "sample_queue.hpp"
#include "stream_message.hpp"

struct LiveFrame {
  plumbline::TimeNs stamp_ns;  ///< of the stream
  plumbline::TimeNs t_ns;      ///< for the estimator
  Message gray;
  std::optional<Message> depth;
};
using LiveQueue = SampleQueue<LiveFrame>;
using LiveSample = LiveQueue::Sample;
