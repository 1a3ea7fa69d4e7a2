#!/usr/bin/env bash
# Runs a Slurm cluster on the loopback interface of this machine, for testing `sheaf farm`. Uses munged, slurmctld and
# slurmd of the Debian packages slurmctld, slurmd, slurm-client and munge, with all their state in one folder.
#
#   tools/farm/slurm.sh install          installs these packages
#   tools/farm/slurm.sh start FOLDER     starts the daemons; then: export SLURM_CONF=FOLDER/slurm.conf
#   tools/farm/slurm.sh stop FOLDER      cancels all jobs and stops the daemons
#
# Exit code 77: the packages are missing, or the user is not root, whom the daemons require.
set -euo pipefail
PATH=$PATH:/usr/sbin:/sbin

fail() { echo "slurm: $2" >&2; exit "$1"; }

free_port() {
  python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}

# wait_for SECONDS WHAT COMMAND...: waits until the command succeeds
wait_for() {
  local seconds=$1 what=$2
  shift 2
  for ((i = 0; i < seconds * 10; ++i)); do
    "$@" >/dev/null 2>&1 && return
    sleep 0.1
  done
  tail -n 20 "$folder"/*.log >&2
  fail 1 "$what did not come up within $seconds seconds"
}

# end_daemon PID_FILE: terminates the process of a pid file; kills it after 5 s
end_daemon() {
  local pid
  [[ -s $1 ]] || return 0
  pid=$(<"$1")
  kill "$pid" 2>/dev/null || return 0
  for ((i = 0; i < 50; ++i)); do
    kill -0 "$pid" 2>/dev/null || return 0
    sleep 0.1
  done
  kill -KILL "$pid" 2>/dev/null || true
}

start() {
  for program in munged slurmctld slurmd sbatch; do
    command -v "$program" >/dev/null || fail 77 "$program is missing: run 'tools/farm/slurm.sh install'"
  done
  ((EUID == 0)) || fail 77 "only root may start the daemons"
  mkdir -p "$folder"/{state,spool}
  chmod 755 "$folder"
  local host cpus
  host=$(hostname -s)
  cpus=$(nproc)
  [[ -s $folder/munge.key ]] || head -c 128 /dev/urandom >"$folder/munge.key"
  chmod 600 "$folder/munge.key"
  cat >"$folder/slurm.conf" <<CONF
ClusterName=sheaf
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmUser=root
AuthType=auth/munge
CredType=cred/munge
# Requeued jobs start again once their credentials have expired.
AuthInfo=socket=$folder/munge.socket,cred_expire=5
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0
ReturnToService=2
KillWait=2
MaxArraySize=10001
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=1024
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
  export SLURM_CONF=$folder/slurm.conf
  munged --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
    --seed-file="$folder/munge.seed" --log-file="$folder/munged.log" >/dev/null 2>&1
  wait_for 10 munged test -S "$folder/munge.socket"
  slurmctld -c -f "$folder/slurm.conf"
  wait_for 20 slurmctld scontrol ping
  # This cluster does not use control groups, but slurmd requires a loadable plugin for them. Which one loads depends on
  # the version of Slurm (22.05 does not know 'disabled') and on the mounts of the machine.
  is_idle() { [[ $(sinfo -h -o %T) =~ ^(idle|mixed|allocated)$ ]]; }
  for plugin in cgroup/v1 disabled autodetect; do
    echo "CgroupPlugin=$plugin" >"$folder/cgroup.conf"
    slurmd -c -f "$folder/slurm.conf" 2>/dev/null || continue
    sleep 0.5
    [[ -s $folder/slurmd.pid ]] && kill -0 "$(<"$folder/slurmd.pid")" 2>/dev/null && break
  done
  wait_for 20 slurmd is_idle
  echo "slurm: a cluster of $cpus cores is up; export SLURM_CONF=$folder/slurm.conf"
}

stop() {
  export SLURM_CONF=$folder/slurm.conf
  [[ -s $SLURM_CONF ]] || fail 2 "no cluster in '$folder'"
  if [[ -s $folder/slurmctld.pid ]]; then
    timeout 10 scancel --quiet --user=root >/dev/null 2>&1 || true
    for ((i = 0; i < 50; ++i)); do
      [[ -n $(timeout 5 squeue -h 2>/dev/null || true) ]] || break
      sleep 0.1
    done
  fi
  for daemon in slurmd slurmctld munged; do end_daemon "$folder/$daemon.pid"; done
  echo "slurm: stopped"
}

case ${1:-} in
  install) exec "$(dirname "${BASH_SOURCE[0]}")/../install_packages.sh" slurmctld slurmd slurm-client munge ;;
  start | stop)
    [[ -n ${2:-} ]] || fail 2 "the folder is missing: tools/farm/slurm.sh $1 FOLDER"
    folder=$(realpath -m "$2")
    [[ $folder != *[[:space:],=#]* ]] || fail 2 "Slurm does not support spaces, commas, '=' and '#' in folder names"
    "$1"
    ;;
  *) fail 2 "usage: tools/farm/slurm.sh install | start FOLDER | stop FOLDER" ;;
esac
