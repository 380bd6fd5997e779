"""How a data set is loaded, as its card shows it; the paths are those in its folder."""

XARRAY = """\
import gearcase

data = gearcase.open_dataset(".")                      # reads a run when it is used
train = data.isel(run=(data.split == "train") & (data.status == "done"))
first = train.acceleration[0]                          # (sensor, axis, time), m/s2
print(first.std("time"))

for one in gearcase.pieces(train, 0.1, noise_m_s2=0.01):   # a run at a time: (piece, sensor, axis, time)
    print(int(one.run[0]), str(one.label.values[0]), one.shape)
"""

PLAIN = """\
import xarray

signals = xarray.open_zarr("signals.zarr", consolidated=False, chunks=None)   # without gearcase, without labels
print(signals.acceleration.sizes)
"""

PANDAS = """\
import pandas

rows = pandas.read_parquet("rows.parquet")             # a line per run: variables, labels, split
print(rows.groupby(["split", "label"]).size())
"""

SKLEARN = """\
import pandas
from sklearn.ensemble import RandomForestClassifier

rows = pandas.read_parquet("rows.parquet").set_index("run")
features = pandas.read_parquet("features.parquet")     # made by: gearcase dataset features .
wide = features.pivot(index="run", columns=["sensor", "axis"]).dropna(axis="columns")
wide.columns = ["_".join(names) for names in wide.columns]
table = rows.join(wide, how="inner")
train, test = table[table.split == "train"], table[table.split == "test"]
model = RandomForestClassifier(random_state=0).fit(train[wide.columns], train.label)
print(model.score(test[wide.columns], test.label))
"""

TORCH = """\
import gearcase
import torch

class Pieces(torch.utils.data.IterableDataset):
    def __init__(self, part):
        data = gearcase.open_dataset(".")
        self.data = data.isel(run=(data.split == part) & (data.status == "done"))
        self.labels = sorted(set(self.data.label.values))

    def __iter__(self):
        for one in gearcase.pieces(self.data, 0.1, noise_m_s2=0.01):
            label = self.labels.index(one.label.values[0])
            for signal in torch.tensor(one.values).flatten(1, 2):   # (sensor and axis, time)
                yield signal, label

batches = torch.utils.data.DataLoader(Pieces("train"), batch_size=32)   # runs come in order: shuffle them for training
"""


def loading() -> str:
    """The part of the card on loading."""
    blocks = {
        "xarray, by run": XARRAY,
        "xarray alone": PLAIN,
        "pandas": PANDAS,
        "scikit-learn": SKLEARN,
        "PyTorch": TORCH,
    }
    return "\n\n".join(f"### {name}\n\n```python\n{code}```" for name, code in blocks.items())
