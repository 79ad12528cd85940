#pragma once
/// Everything an estimator is composed of. Firmware that minds its compile time includes what it names instead.

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/camera/double_sphere.hpp"
#include "plumbline/camera/equidistant.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/systems/rgbd_inertial_vio.hpp"
