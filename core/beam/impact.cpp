// A sphere on a beam, and its exported functions; arrays are C-contiguous doubles, complex numbers two of them.
#include <functional>
#include "../math/linear.hpp"
#include "../methods/events.hpp"
#include "../methods/step_control.hpp"
#include "modes.hpp"

namespace core::beam {

// The force while they touch, by two methods. Collocation: within a step the force is the cubic through its values at four
// points of Gauss and Lobatto, which obey  f = c alpha^1.5,  alpha = s - w - tail f  (paper 2, eqs. 1 and 5).
//
// Every mode answers such a force exactly, so that the step follows the duration of the contact, not the highest mode,
// which would set that of an explicit method. The force starts and ends as (time)^1.5: steps double from a short first
// one and halve again towards separation, where the last step is fitted to alpha = 0.

// Coefficients of powers of u of the cubic that is 1 at one of the POINTS and 0 at the others.
constexpr Force lagrange_cubic(int point) {
  Force coefficients{1.0};
  for (int node = 0, degree = 0; node < TERMS; node++) {
    if (node == point) continue;
    double scale = 1.0 / (POINTS[point] - POINTS[node]);
    for (int k = ++degree; k >= 0; k--)
      coefficients[k] = scale * ((k ? coefficients[k - 1] : 0.0) - POINTS[node] * coefficients[k]);
  }
  return coefficients;
}
constexpr Force CUBIC[TERMS] = {lagrange_cubic(0), lagrange_cubic(1), lagrange_cubic(2), lagrange_cubic(3)};

class Collocation {
 public:
  Collocation(const Impact &impact, double shortest, double longest)
      : impact(impact), modes(impact.modes), sphere(impact.sphere), shortest(shortest), longest(longest) {}

  // One contact from piece `first`, whose start, states and motion are set: how it ended, and `first` as the next piece.
  Status contact(int &first) {
    int &piece = first;
    double contact_start = impact.start[piece], alpha = 0.0, alpha_rate = impact.approach_rate(piece);
    force[0] = 0.0;
    for (; piece + 1 < impact.capacity; piece++) {
      if (*impact.stop) return STOPPED;
      double span = std::min(longest, std::max(shortest, impact.start[piece] - contact_start)),
             left = impact.end_time - impact.start[piece];
      if (alpha_rate < 0.0) span = std::min(span, std::max(shortest, -0.5 * alpha / alpha_rate));
      Status ended = step(piece, std::min(span, left), alpha, alpha_rate);
      if (ended == NOT_FINITE || ended == STALLED) return ended;
      impact.close(piece, length, cubic(), steps[LAST]);
      alpha = approach[LAST], alpha_rate = (approach[LAST] - approach[LAST - 1]) / ((1.0 - POINTS[LAST]) * length);
      force[0] = force[LAST + 1];
      if (ended == SEPARATED) return piece++, ended;
      if (length >= left) return piece++, TIME_UP;
    }
    return FULL;
  }

 private:
  static constexpr int UNKNOWN = TERMS - 1, LAST = UNKNOWN - 1;  // values at the points after the first
  static constexpr int MOST_ITERATIONS = 50;
  using Values = std::array<double, UNKNOWN>;

  const Impact &impact;
  const Modes &modes;
  const Sphere &sphere;
  double shortest, longest, length = 0.0;
  ModeSteps steps[UNKNOWN];      // to each point
  double compliance[UNKNOWN][TERMS];   // approach by a unit force at each of the POINTS
  Values approach;
  std::array<double, TERMS> force;  // at POINTS

  Force cubic() const {
    Force force_cubic{};
    for (int j = 0; j < TERMS; j++)
      for (int k = 0; k < TERMS; k++) force_cubic[k] += CUBIC[j][k] * force[j];
    return force_cubic;
  }

  void set_length(double new_length) {
    if (new_length == length) return;
    length = new_length;
    for (int i = 0; i < UNKNOWN; i++) {
      double share = POINTS[i + 1], span = share * length;
      steps[i].set(modes, span);
      Force response_of_powers = steps[i].compliance_of_powers;
      for (int k = 0; k < TERMS; k++) response_of_powers[k] += span * span / ((k + 1) * (k + 2) * sphere.mass);
      for (int j = 0; j < TERMS; j++) {
        Force part = CUBIC[j].first_part(share);
        compliance[i][j] = 0.0;
        for (int k = 0; k < TERMS; k++) compliance[i][j] -= response_of_powers[k] * part[k];
      }
    }
  }

  // Newton's method for the approaches, from linear extrapolation; true where it converged.
  bool solve(int piece, double alpha, double alpha_rate) {
    Values free, slope;
    for (int i = 0; i < UNKNOWN; i++) {
      double span = POINTS[i + 1] * length;
      free[i] = sphere.free_position(impact.motion[piece], span) - steps[i].free_deflection(modes, impact.state(piece));
      free[i] += compliance[i][0] * force[0];
      approach[i] = alpha + alpha_rate * span;
    }
    double change = 0.0, greatest = 0.0;
    for (int iteration = 0; iteration < MOST_ITERATIONS; iteration++) {
      for (int i = 0; i < UNKNOWN; i++) {
        auto spring = sphere.spring(approach[i]);
        force[i + 1] = spring.load, slope[i] = spring.stiffness;
      }
      SquareMatrix<UNKNOWN> a;
      Values b;
      greatest = change = 0.0;
      for (int i = 0; i < UNKNOWN; i++) {
        b[i] = free[i] - approach[i] - modes.tail * force[i + 1];
        for (int j = 0; j < UNKNOWN; j++) b[i] += compliance[i][j + 1] * force[j + 1], a[i][j] = -compliance[i][j + 1] * slope[j];
        a[i][i] += 1.0 + modes.tail * slope[i];
        greatest = std::max(greatest, std::fabs(approach[i]));
      }
      if (!core::solve(a, b)) return false;
      for (int i = 0; i < UNKNOWN; i++) approach[i] += b[i], change = std::max(change, std::fabs(b[i]));
      if (!std::isfinite(b[0] + b[1] + b[2])) return false;
      if (change <= 1e-15 * greatest) return true;
    }
    return change <= 1e-11 * greatest;
  }

  // One step of at most `span` in which the bodies press all along, or that ends where they separate.
  Status step(int piece, double span, double alpha, double alpha_rate) {
    for (;; span = std::max(shortest, 0.5 * span)) {
      set_length(span);
      bool solved = solve(piece, alpha, alpha_rate);
      if (!std::isfinite(approach[0] + approach[LAST])) return NOT_FINITE;
      int gap = 0;
      while (gap < UNKNOWN && approach[gap] > 0.0) gap++;
      if (solved && gap == UNKNOWN) return OK;
      if (span > shortest) continue;
      if (!solved) return STALLED;
      find_separation(piece, alpha, alpha_rate, POINTS[gap + 1] * span);
      force[TERMS - 1] = 0.0;
      return SEPARATED;
    }
  }

  // Makes the step, of at most `span`, at whose end the approach is zero.
  void find_separation(int piece, double alpha, double alpha_rate, double span) {
    double before = alpha > 0.0 ? alpha : std::fabs(alpha_rate) * span, after = 0.0;
    auto make = [&](double tried) {
      if (*impact.stop) return void(after = 0.0);
      set_length(tried);
      solve(piece, alpha, alpha_rate);
      after = approach[LAST];
    };
    make(span);
    if (after < 0.0) step_to_sign_change(std::identity{}, make, before, after, span, NEAR_ZERO * before);
  }
};

// Paper 2, eq. (9): the contact force of a sphere on a beam as a Volterra integral equation, by product integration.
//
//     (f / c)^(2/3) = s_0(t) - w_0(t) - integral of f(u) [(t - u) / m + G(t - u)] du - tail f(t),
//     G(t) = sum shape^2 / (modal mass * Im lambda) exp(Re lambda t) sin(Im lambda t),
//
// s_0 and w_0 being sphere and beam without the force. The force is piecewise linear on even steps and the kernel is
// integrated exactly against it, so that the error falls as step^2. The kernel is a sum of exponentials and a power of
// time: the effect of the past force is known from the modes and the sphere alone, and each step is one scalar
// equation, solved by Newton's method; Picard's iteration diverges in steps longer than a fifth to a half of the contact.

class Volterra {
 public:
  Volterra(const Impact &impact, double length) : impact(impact), length(length) {}

  // One contact, as `Collocation::contact`.
  Status contact(int &first) {
    int &piece = first;
    double low = 0.0;
    for (; piece + 1 < impact.capacity; piece++) {
      if (*impact.stop) return STOPPED;
      double left = impact.end_time - impact.start[piece];
      steps.set(impact.modes, std::min(length, left));
      double high = load(free_approach(piece, steps, low), response(steps, 0.0, 1.0) + impact.modes.tail);
      if (!std::isfinite(high)) return NOT_FINITE;
      if (high <= 0.0) {
        ModeSteps last;
        double before = impact.sphere.approach(low), after = 0.0;
        auto make = [&](double span) {
          last.set(impact.modes, span);
          after = free_approach(piece, last, low);
        };
        make(steps.span);
        if (after < 0.0 && before > 0.0) step_to_sign_change(std::identity{}, make, before, after, steps.span, NEAR_ZERO * before);
        impact.close(piece++, last.span, line(low, 0.0), last);
        return SEPARATED;
      }
      impact.close(piece, steps.span, line(low, high), steps);
      low = high;
      if (steps.span >= left) return piece++, TIME_UP;
    }
    return FULL;
  }

 private:
  const Impact &impact;
  double length;
  ModeSteps steps;

  static Force line(double low, double high) { return {low, high - low, 0.0, 0.0}; }

  // Approach [m] lost at the end of a step by a force that goes from `low` to `high` in it.
  double response(const ModeSteps &step, double low, double high) const {
    Force force = line(low, high);
    return drop(impact.sphere.mass, step.span, force) + force[0] * step.compliance_of_powers[0] +
           force[1] * step.compliance_of_powers[1];
  }

  // Approach [m] at the end of a step over which the force falls from `low` to zero.
  double free_approach(int piece, const ModeSteps &step, double low) const {
    double travel = impact.sphere.free_position(impact.motion[piece], step.span);
    return travel - step.free_deflection(impact.modes, impact.state(piece)) - response(step, low, 0.0);
  }

  // Force [N] with (f / c)^(2/3) + compliance f = approach, by Newton's method on y = f^(1/3); zero for a gap.
  double load(double approach, double compliance) const {
    if (approach <= 0.0) return 0.0;
    double scale = impact.sphere.approach(1.0), y = std::sqrt(approach / scale);
    for (int iteration = 0; iteration < 100; iteration++) {
      double change = (y * y * (scale + compliance * y) - approach) / (y * (2.0 * scale + 3.0 * compliance * y));
      y -= change;
      if (std::fabs(change) <= 1e-15 * y) break;
    }
    return y * y * y;
  }
};

}  // namespace core::beam

using namespace core;
using namespace core::beam;

// Arguments of all functions: `count` modes, their `rate` (count, 2) and `shape` (count,); `numbers`: modal mass, tail,
// mass, Hertz's coefficient and gravity of the sphere, time to reach; arrays of `capacity` pieces as in Impact.
#define IMPACT_ARGUMENTS                                                                                                 \
  std::int64_t count, const double *rate, const double *shape, const double *numbers, const volatile std::uint8_t *stop, \
      std::int64_t capacity, double *start, double *length, double *force, double *states, double *motion, double *work
#define IMPACT impact_of(count, rate, shape, numbers, stop, capacity, start, length, force, states, motion, work)

namespace {

Impact impact_of(IMPACT_ARGUMENTS) {
  Modes modes(int(count), reinterpret_cast<const Complex *>(rate), shape, numbers[0], numbers[1]);
  return {modes,
          {numbers[2], numbers[3], numbers[4]},
          numbers[5],
          stop,
          int(capacity),
          start,
          length,
          reinterpret_cast<Force *>(force),
          reinterpret_cast<Complex *>(states),
          reinterpret_cast<SphereMotion *>(motion),
          work};
}

}  // namespace

// One contact by steps of `shortest` to `longest` [s], or by Volterra's equation (`by_volterra`) in steps of `longest`, from
// the piece `reached[0]`, whose start, states and motion are set; `reached` becomes the next piece. Returns the status.
CORE_EXPORT std::int64_t core_beam_contact(IMPACT_ARGUMENTS, std::int64_t by_volterra, double shortest, double longest,
                                           std::int64_t *reached) {
  Impact impact = IMPACT;
  int piece = int(*reached);
  Status status = by_volterra ? Volterra(impact, longest).contact(piece) : Collocation(impact, shortest, longest).contact(piece);
  *reached = piece;
  return status;
}

// Closes the pieces from `first` to before `end`, whose lengths and forces are set.
CORE_EXPORT void core_beam_move(IMPACT_ARGUMENTS, std::int64_t first, std::int64_t end) {
  Impact impact = IMPACT;
  ModeSteps steps;
  for (int piece = int(first); piece < end && !*stop; piece++) {
    steps.set(impact.modes, impact.length[piece]);
    impact.close(piece, impact.length[piece], impact.force[piece], steps);
  }
}

// Time [s] from the start of a piece without a force to the next touch.
CORE_EXPORT double core_beam_next_touch(IMPACT_ARGUMENTS, std::int64_t piece, double limit, double shortest) {
  return next_touch(IMPACT, int(piece), limit, shortest);
}

// States of all modes (instants, count, 2), and force [N], position [m] and velocity [m/s] of the sphere (instants, 3) at
// increasing `times` [s] within the pieces.
CORE_EXPORT void core_beam_response(IMPACT_ARGUMENTS, std::int64_t instants, const double *times, double *state, double *sphere) {
  Impact impact = IMPACT;
  Complex *moved = reinterpret_cast<Complex *>(state);
  int piece = 0;
  for (int i = 0; i < instants && !*stop; i++, moved += count, sphere += 3) {
    while (piece + 1 < capacity && times[i] >= impact.start[piece + 1]) piece++;
    double span = times[i] - impact.start[piece], share = span / impact.length[piece];
    Force given = impact.force[piece], begun = given.first_part(share);
    propagate(impact.modes, span, begun, impact.state(piece), moved);
    SphereMotion now = impact.sphere.moved(impact.motion[piece], span, begun);
    sphere[0] = given.value_at(share), sphere[1] = now.position, sphere[2] = now.velocity;
  }
}
