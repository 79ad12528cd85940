// An estimator that has all: check_symbols.cmake must find what bare.cpp must not have.
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/collinear.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/rgbd.hpp"

namespace pl = plumbline;

using Sensors = pl::Rig<pl::Rgbd<pl::Pinhole<float>, 320 * 240>, pl::Imu>;
using Vio =
    pl::Estimator<Sensors, pl::Features<pl::Points<60>, pl::Lines<20>, pl::Collinear<20>>, pl::SlidingWindow<5>>;

template class plumbline::Estimator<Sensors, pl::Features<pl::Points<60>, pl::Lines<20>, pl::Collinear<20>>,
                                    pl::SlidingWindow<5>>;

bool use(Vio& vio, const Vio::Frame& frame, const pl::ImuSample& sample) {
  return bool(vio.add_imu(sample)) && bool(vio.add_frame(frame));
}
