// Built with the flags of physics/predictor_avx2.cc (cmake/library.cmake). Nothing here runs where the CPU lacks them.
#include "backends/featherstone/forward_kernel.h"

#if defined(__FMA__) && defined(__AVX2__)
#include "backends/featherstone/fused.h"
// fused.h comes first: the kernels below must see its functions.
#include "backends/featherstone/tree.h"
#endif

namespace lacuna {

#if defined(__FMA__) && defined(__AVX2__)
namespace {

class FusedKernel final : public ForwardKernel {
 public:
  explicit FusedKernel(const Robot& robot) : tree_(robot) {}
  std::unique_ptr<ForwardKernel> clone() const override { return std::make_unique<FusedKernel>(*this); }
  void set_inertial(int body, const Inertial& inertial) override { tree_.set_inertial(body, 0, inertial); }
  void set_gravity(const Eigen::Vector3d& gravity) override { tree_.set_gravity(0, gravity); }
  void forward_dynamics(const double* q, const double* v, const double* tau, const double* free, double* a,
                        double* imbalance) override {
    tree_.forward_dynamics(in(q), in(v), in(tau), in(free), reinterpret_cast<Fused*>(a),
                           reinterpret_cast<Fused*>(imbalance));
  }

 private:
  static const Fused* in(const double* values) { return reinterpret_cast<const Fused*>(values); }
  Tree<Fused> tree_;
};

}  // namespace
#endif

std::unique_ptr<ForwardKernel> make_fused_kernel([[maybe_unused]] const Robot& robot) {
#if defined(__FMA__) && defined(__AVX2__)
  return std::make_unique<FusedKernel>(robot);
#else
  return nullptr;
#endif
}

}  // namespace lacuna
