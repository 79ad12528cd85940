#include "still_part.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "plumbline/camera/any_camera.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/lie/so3.hpp"

namespace pl = plumbline;

namespace {

constexpr int columns = 16, rows = 12;  // of the grid
constexpr double least_motion_px = 4;   // by the rotation
constexpr double most_still_px = 0.25;  // of a corner that does not move
constexpr int least_corners = 8;        // in a cell
constexpr double still_share = 0.7;     // of these

struct Cell {
  int still = 0, all = 0;
  bool is_still() const { return all >= least_corners && still > still_share * all; }
};

}  // namespace

StillPart find_still_part(const std::vector<TrackedFrame>& frames, const std::vector<ImageRate>& rates,
                          const pl::io::CameraCalibration& calibration) {
  const pl::AnyCamera<double> camera = pl::io::make_camera<double>(calibration);
  std::array<Cell, columns * rows> cells;
  auto rate = rates.begin();
  for (std::size_t i = 1; i < frames.size(); ++i) {
    while (rate != rates.end() && rate->begin_ns < frames[i - 1].t_ns) ++rate;
    if (rate == rates.end() || rate->begin_ns != frames[i - 1].t_ns || !frames[i].follows) continue;
    const double dt = pl::seconds_between(frames[i - 1].t_ns, frames[i].t_ns);
    const pl::SO3<double> R_second_first = pl::SO3<double>::exp(pl::Vec<double, 3>(-dt * rate->rate));
    for (const CornerPair& pair : pairs_of(frames[i - 1], frames[i])) {
      const pl::Projection<double> turned = camera.project(R_second_first * pair.first->bearing);
      if (!turned.valid || !((turned.uv - pair.first->uv).norm() > least_motion_px)) continue;
      const int x = std::clamp(int(pair.first->uv.x() * columns / calibration.width), 0, columns - 1);
      const int y = std::clamp(int(pair.first->uv.y() * rows / calibration.height), 0, rows - 1);
      Cell& cell = cells[std::size_t(y * columns + x)];
      ++cell.all;
      cell.still += (pair.second->uv - pair.first->uv).norm() < most_still_px;
    }
  }
  StillPart out;
  int still = 0, left = columns, top = rows, right = -1, bottom = -1;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      if (!cells[std::size_t(y * columns + x)].is_still()) continue;
      ++still;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  if (still == 0) return out;
  out.share = double(still) / (columns * rows);
  out.left = left * calibration.width / columns;
  out.right = (right + 1) * calibration.width / columns;
  out.top = top * calibration.height / rows;
  out.bottom = (bottom + 1) * calibration.height / rows;
  return out;
}
