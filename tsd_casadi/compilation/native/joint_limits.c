/* What velocity and position leave of a joint's acceleration, and who yields. */
#include <math.h>

#include "tick.h"

void bound_accelerations(const struct joint_limits* s, const double* limit, enum yielding yielding,
                         double* lower, double* upper) {
  for (int i = 0; i < N_TAU; i++) {
    double low = -limit[i], high = limit[i];
    if (yielding < YIELDING_VELOCITY) {
      low = fmax(low, s->velocity_lower[i]);
      high = fmin(high, s->velocity_upper[i]);
    }
    if (yielding < YIELDING_POSITION) {
      low = fmax(low, s->position_lower[i]);
      high = fmin(high, s->position_upper[i]);
    }
    upper[i] = fmax(high, -limit[i]);
    lower[i] = fmin(low, upper[i]);
  }
}

double state_of_torque(double at, double v, double limit, double stall, double no_load) {
  if (at == 0.0) return at;
  const double share = at > 0.0 ? v / no_load : -v / no_load;
  return stall * fmax(1.0 - share, 0.0) < limit ? 6.0 * at : at;
}

/* below -1, above 1, between 0, up to a share of 1 + |bound| */
static int side_of(double value, double lower, double upper) {
  if (value > upper + LIMIT_TOLERANCE * (1.0 + fabs(upper))) return 1;
  if (value < lower - LIMIT_TOLERANCE * (1.0 + fabs(lower))) return -1;
  return 0;
}

/* Which limit a joint is past now, whatever comes next; 0 for none. */
static double passed_limit(const double* request, int i) {
  const int joint = N_V - N_TAU + i; /* in q after a quaternion */
  const double q = request[REQUEST_Q + joint + 1], v = request[REQUEST_V + joint];
  const double fastest = request[REQUEST_VELOCITY + i];
  if (request[REQUEST_POSITION_ACTIVE]) {
    if (q > request[REQUEST_POSITION_UPPER + i]) return 7.0;
    if (q < request[REQUEST_POSITION_LOWER + i]) return -7.0;
  }
  if (request[REQUEST_VELOCITY_ACTIVE] && fabs(v) > fastest) return v > 0.0 ? 8.0 : -8.0;
  return 0.0;
}

double state_of_joint(const struct joint_limits* s, const double* request, int i, double qdd,
                      double lower, double upper, double at) {
  const int by_position = side_of(qdd, s->position_lower[i], s->position_upper[i]);
  const int by_velocity = side_of(qdd, s->velocity_lower[i], s->velocity_upper[i]);
  if (by_position || by_velocity) return 3.0 * (by_position ? by_position : by_velocity);
  if (at > 0.0 && s->position_upper[i] <= upper) return 4.0;
  if (at < 0.0 && s->position_lower[i] >= lower) return -4.0;
  if (at > 0.0 && s->velocity_upper[i] <= upper) return 5.0;
  if (at < 0.0 && s->velocity_lower[i] >= lower) return -5.0;
  const double passed = passed_limit(request, i);
  return passed != 0.0 ? passed : at;
}
