// Explicit Runge-Kutta methods: tableaux, and a step of one small system.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include "step_control.hpp"

namespace core {

// A method of bearings (bearing_twin/coefficients.py). `error` weighs all slopes and that at the new state for the error
// estimate; all zero: none.
struct RungeKuttaMethod {
  int stages, order;
  double a[MAX_STAGES][MAX_STAGES - 1], node[MAX_STAGES], weight[MAX_STAGES], error[MAX_STAGES + 1];

  bool adapts() const {
    return std::any_of(error, error + stages + 1, [](double weight) { return weight != 0.0; });
  }
};

// A method of small systems.

constexpr int MAX_EXPLICIT_STAGES = 12;

// `error` weighs the stages for the error estimate, all zero: none. With a `third`, the estimate is divided by the length
// of (`error`, 0.1 `third`), as in Hairer's dop853.
struct ExplicitMethod {
  int stages, order;
  double a[MAX_EXPLICIT_STAGES][MAX_EXPLICIT_STAGES];
  double weight[MAX_EXPLICIT_STAGES], error[MAX_EXPLICIT_STAGES], third[MAX_EXPLICIT_STAGES];
};

// The classical method (Kutta 1901).
constexpr ExplicitMethod RK4{4, 4, {{}, {0.5}, {0, 0.5}, {0, 0, 1}}, {1 / 6.0, 2 / 6.0, 2 / 6.0, 1 / 6.0}, {}, {}};

// Dormand and Prince's method of order 8 with error estimates of orders 5 and 3 (Hairer, Norsett and Wanner, Solving ODE I,
// section II.10; the numbers of SciPy's DOP853).
constexpr ExplicitMethod DOP853{
    12,
    8,
    {
        {},
        {0.05260015195876773},
        {0.0197250569845379, 0.0591751709536137},
        {0.02958758547680685, 0, 0.08876275643042054},
        {0.2413651341592667, 0, -0.8845494793282861, 0.924834003261792},
        {0.037037037037037035, 0, 0, 0.17082860872947386, 0.12546768756682242},
        {0.037109375, 0, 0, 0.17025221101954405, 0.06021653898045596, -0.017578125},
        {0.03709200011850479, 0, 0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023},
        {0.6241109587160757, 0, 0, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894,
         -43.48988418106996},
        {0.47766253643826434, 0, 0, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423,
         -33.28821096898486, -0.020331201708508627},
        {-0.9371424300859873, 0, 0, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696,
         22.739487099350505, 2.4936055526796523, -3.0467644718982196},
        {2.273310147516538, 0, 0, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996,
         -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636},
    },
    {0.054293734116568765, 0, 0, 0, 0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199,
     -0.1521609496625161, 0.20136540080403034, 0.04471061572777259},
    {0.01312004499419488, 0, 0, 0, 0, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864, -0.35032884874997366,
     0.3341791187130175, 0.08192320648511571, -0.022355307863886294},
    {-0.18980075407240762, 0, 0, 0, 0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, -0.4226823213237919,
     -0.1521609496625161, 0.20136540080403034, 0.02265179219836082}};

template <std::size_t NUMBERS>
using Numbers = std::array<double, NUMBERS>;

// The state `step` [s] after `state`, written to `out`; returns the error, a root mean square in units of `scales`, zero
// without an estimate. `rates(state, slopes)` fills the slopes of the first MOVING numbers; the others are constant.
template <std::size_t MOVING, std::size_t NUMBERS, class Rates>
double explicit_step(const ExplicitMethod &method, const Rates &rates, const Numbers<NUMBERS> &scales,
                     const Numbers<NUMBERS> &state, double step, Numbers<NUMBERS> &out) {
  std::array<Numbers<MOVING>, MAX_EXPLICIT_STAGES> slopes;
  Numbers<NUMBERS> trial = state;
  for (int i = 0; i < method.stages; i++) {
    for (std::size_t n = 0; n < MOVING; n++) trial[n] = state[n];
    for (int j = 0; j < i; j++)
      if (double weight = step * method.a[i][j]; weight != 0.0)
        for (std::size_t n = 0; n < MOVING; n++) trial[n] += weight * slopes[j][n];
    rates(trial, slopes[i]);
  }
  Numbers<MOVING> increment{}, fifth_error{}, third_error{};
  for (int i = 0; i < method.stages; i++)
    for (std::size_t n = 0; n < MOVING; n++) {
      increment[n] += method.weight[i] * slopes[i][n];
      fifth_error[n] += method.error[i] * slopes[i][n];
      third_error[n] += method.third[i] * slopes[i][n];
    }
  out = state;
  double fifth = 0.0, third = 0.0;
  for (std::size_t n = 0; n < MOVING; n++) {
    out[n] += step * increment[n];
    double e5 = fifth_error[n] / scales[n], e3 = third_error[n] / scales[n];
    fifth += e5 * e5, third += e3 * e3;
  }
  return fifth == 0.0 ? 0.0 : step * fifth / std::sqrt((fifth + 0.01 * third) * MOVING);
}

}  // namespace core
