/* A recording in memory, for a test in C: everything is read before the estimator is made. */
#ifndef RECORDED_H
#define RECORDED_H

#include "plumbline.h"

#ifdef __cplusplus
extern "C" {
#endif

struct recorded {
  plumbline_config config;
  int count;
};

/* Reads the first seconds of a EuRoC folder. Returns 0 where there is none. */
int recorded_open(const char* folder, double seconds, struct recorded* out);
/* Item i is a sample or a frame; the other one has the time 0. */
void recorded_item(int i, plumbline_imu_sample* sample, plumbline_frame* frame);
/* Distance between the true positions of the body at two times [m]. */
double recorded_distance(int64_t from_ns, int64_t to_ns);

#ifdef __cplusplus
}
#endif
#endif
