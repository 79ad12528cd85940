#include "live_page.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdio>
#include <sstream>
#include <stdexcept>
#include <utility>

#ifdef PLUMBLINE_HAS_HTTP
#include <httplib.h>
#endif

#include "map_json.hpp"
#include "misuse.hpp"
#include "page.hpp"

namespace {

constexpr std::size_t most_of_answer = 10'000;      // poses
constexpr std::size_t most_relocalizations = 1000;  // that the page shows

}  // namespace

#ifdef PLUMBLINE_HAS_HTTP

struct LivePage::Server {
  httplib::Server http;
  std::thread thread;
};

namespace {

std::uint64_t number_of(const httplib::Request& request, const char* name) {
  const std::string text = request.get_param_value(name);
  std::uint64_t out = 0;
  std::from_chars(text.data(), text.data() + text.size(), out);  // 0 of what is no number
  return out;
}

}  // namespace

LivePage::LivePage(int port, std::string title, bool has_imu)
    : title_(std::move(title)), has_imu_(has_imu), server_(std::make_unique<Server>()) {
  httplib::Server& http = server_->http;
  http.Get("/", [this](const httplib::Request&, httplib::Response& response) {
    std::ostringstream page;
    write_page(page, "live", {{"title", title_}, {"has_imu", has_imu_}});
    response.set_content(page.str(), "text/html; charset=utf-8");
  });
  http.Get("/poses", [this](const httplib::Request& request, httplib::Response& response) {
    const auto part = static_cast<std::uint32_t>(number_of(request, "part"));
    response.set_header("Cache-Control", "no-store");
    response.set_content(poses(number_of(request, "from"), part).dump(), "application/json");
  });
  http.Get("/map", [this](const httplib::Request& request, httplib::Response& response) {
    response.set_header("Cache-Control", "no-store");
    response.set_content(map(number_of(request, "version")).dump(), "application/json");
  });
  http.set_socket_options([](socket_t socket) {  // not SO_REUSEPORT, which lets two programs share a port
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  const int bound = port == 0 ? http.bind_to_any_port("127.0.0.1") : http.bind_to_port("127.0.0.1", port) ? port : -1;
  if (bound < 0) throw std::runtime_error("--page: port " + std::to_string(port) + " of 127.0.0.1 cannot be used");
  std::fprintf(stderr, "plumbline: note: the page is at http://127.0.0.1:%d/\n", bound);
  server_->thread = std::thread([&http] { http.listen_after_bind(); });
  while (!http.is_running()) std::this_thread::yield();  // or stop() before it would be lost
}

LivePage::~LivePage() {
  server_->http.stop();
  server_->thread.join();
}

#else

struct LivePage::Server {};

LivePage::LivePage(int, std::string title, bool has_imu) : title_(std::move(title)), has_imu_(has_imu) {
  throw Misuse(
      "--page: this program is built without pages (they need libcpp-httplib-dev, libssl-dev and libbrotli-dev)");
}
LivePage::~LivePage() = default;

#endif

void LivePage::add(const FrameOutput& output, bool is_sound, std::size_t dropped) {
  const std::lock_guard lock(mutex_);
  ++frames_;
  dropped_ = dropped;
  health_ = name_of(output.health());
  reason_ = name_of(output.estimate.health.reason);
  total_ms_ = 1e3 * output.timing.total;
  if (!is_sound) return;
  const Pose pose{1e-9 * static_cast<double>(output.pose_ns()), output.T_map_body().p().cast<float>(),
                  output.estimate.T_world_body.p().cast<float>()};
  if (output.map_counts.relocalizations > relocalized_ && relocalizations_.size() < most_relocalizations)
    relocalizations_.push_back(pose);
  relocalized_ = output.map_counts.relocalizations;
  if (sound_++ % every_ != 0) return;
  poses_.push_back(pose);
  if (poses_.size() < most_poses) return;
  for (std::size_t i = 0; 2 * i < poses_.size(); ++i) poses_[i] = poses_[2 * i];
  poses_.resize((poses_.size() + 1) / 2);
  every_ *= 2;
  ++part_;
}

bool LivePage::wants_map() const { return is_map_asked_ && Clock::now() - mapped_ >= std::chrono::seconds(1); }

void LivePage::set_map(MapSnapshot map) {
  auto present = std::make_shared<const MapSnapshot>(std::move(map));
  is_map_asked_ = false;
  mapped_ = Clock::now();
  const std::lock_guard lock(mutex_);
  map_.swap(present);
  ++version_;
}

void LivePage::set_over() {
  const std::lock_guard lock(mutex_);
  is_over_ = true;
}

nlohmann::json LivePage::poses(std::size_t from, std::uint32_t part) const {
  std::vector<Pose> some;
  bool has_map = false;
  nlohmann::json out;
  {
    const std::lock_guard lock(mutex_);
    has_map = map_ != nullptr;
    const std::size_t begin = part == part_ && from <= poses_.size() ? from : 0;
    const std::size_t count = std::min(poses_.size() - begin, most_of_answer);
    some.assign(poses_.begin() + static_cast<std::ptrdiff_t>(begin),
                poses_.begin() + static_cast<std::ptrdiff_t>(begin + count));
    out = {{"part", part_},         {"from", begin},       {"frames", frames_},
           {"dropped", dropped_},   {"health", health_},   {"reason", reason_},
           {"total_ms", total_ms_}, {"is_over", is_over_}, {"is_all", begin + count == poses_.size()},
           {"has_map", has_map}};
  }
  for (const char* name : {"t", "x", "y", "z"}) out[name] = nlohmann::json::array();
  for (const Pose& pose : some) {
    out["t"].push_back(pose.t_s);
    out["x"].push_back(pose.p_map.x());
    out["y"].push_back(pose.p_map.y());
    out["z"].push_back(pose.p_map.z());
  }
  if (!has_map) return out;
  out["world"] = nlohmann::json::array();
  for (const Pose& pose : some) out["world"].push_back({pose.p_world.x(), pose.p_world.y(), pose.p_world.z()});
  return out;
}

nlohmann::json LivePage::map(std::uint64_t version) const {
  is_map_asked_ = true;
  std::shared_ptr<const MapSnapshot> map;
  std::vector<Pose> relocalizations;
  nlohmann::json out;
  {
    const std::lock_guard lock(mutex_);
    out["version"] = version_;
    if (version == version_ || !map_) return out;
    map = map_;
    relocalizations = relocalizations_;
  }
  out["map"] = json_of_snapshot(*map);
  nlohmann::json& again =
      out["map"]["relocalizations"] = {{"t", nlohmann::json::array()}, {"world", nlohmann::json::array()}};
  for (const Pose& pose : relocalizations) {
    again["t"].push_back(pose.t_s);
    again["world"].push_back({pose.p_world.x(), pose.p_world.y(), pose.p_world.z()});
  }
  return out;
}
