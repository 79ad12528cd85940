#pragma once
/// What `plumbline live` says of each frame: one line of JSON, or one message in the framing of its input.
///                                                                                                  docs/guide/live.md

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "plumbline/core/time.hpp"
#include "runner.hpp"
#include "stream_socket.hpp"

class LiveOutput {
 public:
  /// `format`: json, binary or binary-map, which is binary where there is no map.
  LiveOutput(const Connection& connection, const std::string& format, bool has_map)
      : connection_(connection), is_binary_(format != "json"), tells_map_(has_map && format != "binary") {}

  /// `waiting` frames had come since.
  void add(plumbline::TimeNs stamp_ns, const FrameOutput& output, std::size_t waiting);
  /// Of a frame that gave no estimate, or of the run: {"event": ...}.
  void add_event(const nlohmann::ordered_json& event) const;

 private:
  void write_line(const nlohmann::ordered_json& line) const;

  const Connection& connection_;
  bool is_binary_, tells_map_;
  std::vector<std::uint8_t> map_;  // the last message about it
};

/// The line of a frame.
nlohmann::ordered_json json_of(plumbline::TimeNs stamp_ns, const FrameOutput& output, std::size_t waiting,
                               bool has_map);
