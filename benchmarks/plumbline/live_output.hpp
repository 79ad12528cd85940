#pragma once
/// What `plumbline live` says of each frame: one line of JSON, or one message in the framing of its input.
///                                                                                                  docs/guide/live.md

#include <string>

#include <nlohmann/json.hpp>

#include "plumbline/core/time.hpp"
#include "runner.hpp"
#include "stream_socket.hpp"

class LiveOutput {
 public:
  LiveOutput(const Connection& connection, bool is_binary) : connection_(connection), is_binary_(is_binary) {}

  /// `waiting` frames had come since.
  void add(plumbline::TimeNs stamp_ns, const FrameOutput& output, std::size_t waiting) const;
  /// Of a frame that gave no estimate, or of the run: {"event": ...}.
  void add_event(const nlohmann::ordered_json& event) const;

 private:
  void write_line(const nlohmann::ordered_json& line) const;

  const Connection& connection_;
  bool is_binary_;
};

/// The line of a frame.
nlohmann::ordered_json json_of(plumbline::TimeNs stamp_ns, const FrameOutput& output, std::size_t waiting);
