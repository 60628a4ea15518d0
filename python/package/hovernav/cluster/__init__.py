"""Fleets of logs and campaigns of simulated flights, on this machine or on a Ray cluster.

The work is divided into shards. The result of a shard is one Parquet file below `out/shards`, written whole or not at
all. A run that was interrupted continues: a finished shard is not run again. A worker that is lost costs its shards
only, which run again; `lost` reports them. The files have the same bits for any number of workers, with and without Ray.

Needs pyarrow, and Ray for more than one machine: `pip install "hovernav[cluster]"`.

    >>> import hovernav as hn
    >>> import hovernav.cluster
    >>> fleet = hn.cluster.estimate("logs/*.ulg", out="out/fleet")
    >>> fleet.counts
"""

from ._campaign import CampaignRun, campaign
from ._estimate import FleetRun, estimate
from ._run import ClusterError, Run

__all__ = ["CampaignRun", "ClusterError", "FleetRun", "Run", "campaign", "estimate"]
