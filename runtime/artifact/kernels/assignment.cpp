// Linear assignment: a column for each row, with the least sum of costs. D. F. Crouse, On implementing 2D
// rectangular assignment algorithms, IEEE Transactions on Aerospace and Electronic Systems 52 (4), 2016.
#include <algorithm>
#include <limits>
#include <memory>

#include "declared/assignment.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One matrix, with the state of its assignment. Every step computes as the definition in Python does and
// makes the same choice between equal costs, so that both return the same assignment.
class Assignment {
 public:
  static int64_t scratch_size(int64_t n, int64_t m) { return 2 * n + 5 * m; }

  Assignment(const double* costs, double alone, int64_t n, int64_t m, double* scratch, int64_t* match)
      : costs_(costs),
        alone_(alone),
        n_(n),
        m_(m),
        dual_(scratch),
        price_(dual_ + n),
        length_(price_ + m),
        before_(length_ + m),
        final_(before_ + m),
        owner_(final_ + m),
        match_(match) {}

  void solve() {
    begin();
    const int64_t limit = 2 * n_ * n_;
    for (int64_t step = 0; step < limit; ++step) {
      while (root_ < n_ && match_[root_] != kWaits) ++root_;
      if (giving_ < 0 && root_ == n_) break;
      if (giving_ < 0) extend_path();
      if (giving_ >= 0) give(giving_);
    }
  }

 private:
  // What a row without a column has in place of its index: the row is not processed yet, or is left alone.
  static constexpr int64_t kWaits = -1, kAlone = -2;
  static constexpr double kFree = -1;  // the owner of a column without a row

  // Each row has its cheapest column unless an earlier row has the same one.
  void begin() {
    std::fill_n(price_, m_, 0.0);
    std::fill_n(before_, m_, -1.0);
    std::fill_n(owner_, m_, kFree);
    reset_paths();
    for (int64_t i = 0; i < n_; ++i) {
      const double* const cost = costs_ + i * m_;
      const int64_t best = std::min_element(cost, cost + m_) - cost;
      const bool any = cost[best] < kInfinity;
      dual_[i] = any ? cost[best] : alone_;
      match_[i] = any ? kWaits : kAlone;
      if (!any || owner_[best] != kFree) continue;
      match_[i] = best;
      owner_[best] = static_cast<double>(i);
    }
  }

  void reset_paths() {
    std::fill_n(length_, m_, kInfinity);
    std::fill_n(final_, m_, 0.0);
    row_ = -1;
    reached_ = 0;
    leaving_ = kInfinity;
  }

  // One row more on the shortest path from the root: to the nearest column, to whose row it goes on if the
  // column has one, or to a row that is left alone.
  void extend_path() {
    const int64_t row = row_ < 0 ? root_ : row_;
    const double nearest = measured(row);
    const double alone = reached_ + (alone_ - dual_[row]);
    if (alone < leaving_ || row_ < 0) {
      leaving_ = alone;
      leaver_ = row;
    }
    const int64_t column = nearest_column(nearest);
    const bool gives_up = leaving_ < nearest || nearest == kInfinity;  // both may be infinite
    if (!gives_up && owner_[column] != kFree) {
      final_[column] = 1;
      row_ = static_cast<int64_t>(owner_[column]);
      reached_ = nearest;
      return;
    }
    change_duals(gives_up ? leaving_ : nearest);
    giving_ = column;
    if (gives_up) {
      giving_ = match_[leaver_];
      match_[leaver_] = kAlone;
    }
    reset_paths();
  }

  // Shortens the paths to the columns by those through the row, and returns the least length of a path that
  // is not final.
  double measured(int64_t row) {
    const auto shorten = [cost = costs_ + row * m_, dual = dual_[row], price = price_, reached = reached_,
                          lengths = length_, final = final_, before = before_,
                          number = static_cast<double>(row)](auto d, int64_t k) {
      const auto reduced =
          hn::Sub(hn::Sub(hn::LoadU(d, cost + k), hn::Set(d, dual)), hn::LoadU(d, price + k));
      const auto through = hn::Add(hn::Set(d, reached), reduced);
      const auto old = hn::LoadU(d, lengths + k);
      const auto open = hn::Eq(hn::LoadU(d, final + k), hn::Zero(d));
      const auto shorter = hn::And(hn::Lt(through, old), open);
      const auto length = hn::IfThenElse(shorter, through, old);
      hn::StoreU(length, d, lengths + k);
      hn::StoreU(hn::IfThenElse(shorter, hn::Set(d, number), hn::LoadU(d, before + k)), d, before + k);
      return hn::IfThenElse(open, length, hn::Set(d, kInfinity));
    };
    const Lanes<double> d;
    auto least = hn::Set(d, kInfinity);
    int64_t k = 0;
    for (; k + kLanes<double> <= m_; k += kLanes<double>) least = smaller(shorten(d, k), least);
    double lanes[kLanes<double>];  // the scalar target's MinOfLanes makes the largest number of infinity
    hn::StoreU(least, d, lanes);
    double nearest = *std::min_element(lanes, lanes + kLanes<double>);
    for (; k < m_; ++k) nearest = std::min(nearest, hn::GetLane(shorten(Lane<double>(), k)));
    return nearest;
  }

  // The first free column at this length of the paths that are not final, else the first one at all.
  int64_t nearest_column(double nearest) const {
    int64_t first = -1;
    const auto at = [=, this](auto d, int64_t k) {
      const auto open = hn::Eq(hn::LoadU(d, final_ + k), hn::Zero(d));
      const auto length = hn::IfThenElse(open, hn::LoadU(d, length_ + k), hn::Set(d, kInfinity));
      return any(d, hn::Eq(length, hn::Set(d, nearest)));
    };
    for (int64_t k = 0; k < m_;) {
      if (k + kLanes<double> <= m_ && !at(Lanes<double>(), k)) {
        k += kLanes<double>;
        continue;
      }
      if (at(Lane<double>(), k)) {
        if (owner_[k] == kFree) return k;
        if (first < 0) first = k;
      }
      ++k;
    }
    return std::max<int64_t>(first, 0);
  }

  // At the end of a path of this length: its pairs get the reduced cost zero.
  void change_duals(double total) {
    for (int64_t i = 0; i < n_; ++i)
      if (match_[i] >= 0 && final_[match_[i]] > 0) dual_[i] += total - length_[match_[i]];
    dual_[root_] += total;
    for (int64_t j = 0; j < m_; ++j)
      if (final_[j] > 0) price_[j] -= total - length_[j];
  }

  // The column gets the row before it on the path, whose old column is the next to give.
  void give(int64_t column) {
    const auto row = static_cast<int64_t>(std::max(before_[column], 0.0));
    giving_ = match_[row];
    owner_[column] = static_cast<double>(row);
    match_[row] = column;
  }

  const double* const costs_;
  const double alone_;
  const int64_t n_, m_;
  double* const dual_;                // of rows
  double* const price_;               // the dual values of columns
  double* const length_;              // of the shortest path to each column
  double* const before_;              // the row before the column on this path
  double* const final_;               // 1 if the path is
  double* const owner_;               // the row of each column
  int64_t* const match_;              // the column of each row
  int64_t root_ = 0, row_ = -1;       // of the path: its first and its last row
  double reached_ = 0;                // its length to the last row
  double leaving_ = kInfinity;        // the length of the shortest path to a row that is left alone
  int64_t leaver_ = 0, giving_ = -1;  // this row; the column that gets another row
};

}  // namespace

void linear_sum_assignment(const double* costs, int64_t matrices, int64_t n, int64_t m, const double* alone,
                           int64_t* out) {
  const int64_t size = Assignment::scratch_size(n, m);
  const std::unique_ptr<double[]> scratch(new double[static_cast<size_t>(size * omp_get_max_threads())]);
#pragma omp parallel for
  for (int64_t i = 0; i < matrices; ++i) {
    int64_t* const match = out + i * n;
    Assignment(costs + i * n * m, alone[i], n, m, scratch.get() + size * omp_get_thread_num(), match).solve();
    std::transform(match, match + n, match, [](int64_t column) { return std::max<int64_t>(column, -1); });
  }
}

}  // namespace chiasm::kernels
