// A world with a sensor in it that can be unplugged: it outlives the sensor processes that a test kills, and every new
// one is told how things are.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace cheval::test {

/// Thread-safe. Listens as long as it lives.
class SensorWorld {
  public:
    /// `spec` as hal/sim/openni/sensor_spec.h says, e.g. "sim:seed=3,visit_s=60".
    explicit SensorWorld(const std::string& spec);
    ~SensorWorld();
    SensorWorld(const SensorWorld&) = delete;
    SensorWorld& operator=(const SensorWorld&) = delete;

    /// For the sensor process: what it serves, who listens, and where the runtime with our driver is.
    [[nodiscard]] std::vector<std::string> environment() const;
    /// The same for this process and all that it starts.
    void useInThisProcess() const;

    /// Tells every connected sensor and remembers it for those that come. True when all have obeyed within two
    /// seconds; one that dies meanwhile need not.
    bool tell(const std::string& command);
    /// Sensors that are connected now.
    [[nodiscard]] std::size_t sensors();

    /// "sim:…,start_ns=now" with `seconds` of the visit gone by, so that a sensor that starts later joins in.
    static std::string visitInProgress(const std::string& options, double seconds);

  private:
    void accept();
    [[nodiscard]] std::string state();

    std::string spec_;
    TemporaryFolder folder_;
    std::string path_;
    int listener_ = -1;
    int wake_ = -1;
    std::mutex mutex_;
    std::vector<int> connections_;
    std::map<std::string, std::string> state_;  ///< By kind of fault: the command that holds.
    std::thread thread_;
};

}  // namespace cheval::test
