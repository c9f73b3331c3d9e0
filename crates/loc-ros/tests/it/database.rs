//! Small databases of SQLite, as bags of ROS 2 are: written here byte by byte, and by SQLite itself
//! (gzipped, in base64).

use base64::Engine;
use std::io::Read as _;

/// Bytes of a page; no table here needs a second one.
const PAGE: usize = 8192;

/// What a row holds.
enum Value<'a> {
    /// Stands for the number of the row.
    Null,
    Integer(i64),
    Text(&'a str),
    Blob(&'a [u8]),
}

/// A bag with topics (number, name, type) and messages (topic, time \[ns\], data).
pub(crate) fn database(topics: &[(i64, &str, &str)], messages: &[(i64, i64, &[u8])]) -> Vec<u8> {
    let topics: Vec<_> = topics
        .iter()
        .map(|(id, name, kind)| {
            cell(*id, &[Value::Null, Value::Text(name), Value::Text(kind), Value::Text("cdr")])
        })
        .collect();
    let messages: Vec<_> = (1..)
        .zip(messages)
        .map(|(id, (topic, time, data))| {
            let (topic, time) = (Value::Integer(*topic), Value::Integer(*time));
            cell(id, &[Value::Null, topic, time, Value::Blob(data)])
        })
        .collect();
    let tables = [
        ("topics", 2, "id INTEGER PRIMARY KEY,name TEXT,type TEXT,serialization_format TEXT"),
        ("messages", 3, "id INTEGER PRIMARY KEY,topic_id INTEGER,timestamp INTEGER,data BLOB"),
    ];
    let schema = tables.map(|(name, root, columns)| {
        let sql = format!("CREATE TABLE {name}({columns})");
        let text = Value::Text;
        cell(root, &[text("table"), text(name), text(name), Value::Integer(root), text(&sql)])
    });
    let mut first = page(100, &schema);
    first[..16].copy_from_slice(b"SQLite format 3\0");
    first[16..18].copy_from_slice(&(PAGE as u16).to_be_bytes());
    first[18..24].copy_from_slice(&[1, 1, 0, 64, 32, 32]);
    first[59] = 1;
    [first, page(0, &topics), page(0, &messages)].concat()
}

/// A leaf of a table's tree; its head is at `head`.
fn page(head: usize, cells: &[Vec<u8>]) -> Vec<u8> {
    let mut page = vec![0; PAGE];
    let mut end = PAGE;
    page[head] = 0x0d;
    page[head + 3..head + 5].copy_from_slice(&(cells.len() as u16).to_be_bytes());
    for (index, cell) in cells.iter().enumerate() {
        end -= cell.len();
        page[end..end + cell.len()].copy_from_slice(cell);
        let pointer = head + 8 + 2 * index;
        page[pointer..pointer + 2].copy_from_slice(&(end as u16).to_be_bytes());
        assert!(pointer + 2 < end, "the rows of a table fit on one page");
    }
    page[head + 5..head + 7].copy_from_slice(&(end as u16).to_be_bytes());
    page
}

fn cell(id: i64, row: &[Value<'_>]) -> Vec<u8> {
    let (mut kinds, mut values) = (Vec::new(), Vec::new());
    for value in row {
        match value {
            Value::Null => kinds.extend(varint(0)),
            Value::Integer(number) => {
                kinds.extend(varint(6));
                values.extend(number.to_be_bytes());
            }
            Value::Text(text) => {
                kinds.extend(varint(13 + 2 * text.len() as u64));
                values.extend(text.as_bytes());
            }
            Value::Blob(blob) => {
                kinds.extend(varint(12 + 2 * blob.len() as u64));
                values.extend(*blob);
            }
        }
    }
    let record = [varint(1 + kinds.len() as u64), kinds, values].concat();
    [varint(record.len() as u64), varint(id as u64), record].concat()
}

/// A number in groups of seven bits, the highest first.
pub(crate) fn varint(number: u64) -> Vec<u8> {
    let groups = (0..9).rev().map(|k| (number >> (7 * k)) as u8 & 0x7f);
    let mut bytes: Vec<u8> = groups.skip_while(|group| *group == 0).collect();
    if bytes.is_empty() {
        bytes.push(0);
    }
    let last = bytes.len() - 1;
    bytes[..last].iter_mut().for_each(|byte| *byte |= 0x80);
    bytes
}

/// 35840 bytes.
pub(crate) const DB3: &str = "H4sIAAAAAAACA+2dd3hURRfGzxAIvZfQAkvvvYYaSqghQAi9hEACBgkEEjooGywIqKAgRUUsYMGCXQEBFRQUkF6ld4UFG3b97oY97Ds5hw/I9/3hI9lHJ3kv+9u5M2fO3HsneTM9uofHJ8e5ho0emxCT7KpHmcgYCnW5iCiz83878r8CfMf4Zejmr8xUc6jJ4v0uU6rOQhmvf9QrtzeQZic5/2W8/g2vGiaQinUsmLtW4uj4UcnD40YnxCWPnRSdkDQ8qZZT1OrmPdwjOSYhMS52aOxYb0JWMpW9ZDvzu7lqvjMXzTlz0hwxB8xus91sMRvNerPavGtWmZVmhVlmlpj55hEz06SYqWa8STQjTKwZZPqYSBNu2plQ08TUNzWvfeS/6hWWUt4p26aUdMrWKYWcslVKLqcMTfHOik3dU52yiXucU4a4E5yysTvOKRu6BzplA3dPp6zj7uKUtd1hTlnT3dwbLXcDp6zuruGUVd0VnLKiO9gpK7gLO2V5tzc9y7q9QSozzSlc3k8v7f3wYO9nF491imIDnKJolFMEhTtF4bZOUaiZUxSs7xT56jpF3mpOkaucU+Qs4RQ5CjpF9pxOkS3AOy1nN0O87WtjLpujZptZa14xi8wDJvna4YzX//xqljsgMFNQ0OIZ+Yd5thlvTBvBkVV0xTlSC448RrucI9XgyDh61zlSDo70oUXOkVK5AgKN70jTKc6BInCgpHdk5PEfuPSnd8jlhgPHSudOvbAPItOF3ne+/D9e7oKZsgYFBxv3pOTeAYFBlYLNpPhRsXETk+MT4pK8E090fOxE59ukmOFxSZnbRIa1igpzdYxoG9bHZb3F1TXCxW9zVb7+T65WPdpUgTpihoyM47fx1wDfp0a1ah0edv1DKsfHOvVEhbUPi3R1i+zYpVVkX1fnsL7Vk0cnxg+Nhn+M6BrliugZHl7dX6n4J1dsTHKMq3V419bXj1Vx1zZZg4oVMylNU88q9XOTrpWZrDO6duxG5zMqJiHOFRXWJwpOZFJi2kNJcWPjY0bGT45Jjh89Ktp3A2e/ZfSwYXFj42Kjx4xOik4cO3pY/EinJ623VHHilbVM2XLlK1SsVLlK1WrVa9SsVbtO3Xr1GzRs1DikSdNmzVu0DG3Vuk3bsHbtO3Ts1Dm8S0TXbt0je0T17NW7T99+/QcMHBQ9OGbI0Ni4YcPvih9x98iEUaMTx4xNSh43fsLESZOnTJ12z73T3Skz7rv/gQdnPjRr9pyHH3l07rzHHp+/4ImFixYvefKpp5c+s+zZ555/YfmKF196+ZWVr772+hur3nzr7Xfefe/9Dz5cvWbtR+vWb/j4k083bvrs881bvvhy67btX+3YuWv3nr379h84eOjw10eOHjt+4uSp02fOnjt/4ZtvL17yXL7y3fc//PjT1Z9/+fU3MpkCMmcJzJote46cuXLnyZsvf4GChQoXCSparHiJksGlSrvu+KZ7EzYj8ndu06/N/87tx/N0l/fLf32FBGSh7IGxvovHp94nwKy+RzvvLVBCTKLvjVda+r6u9329NyQTop8wagR6XKCzIpxb2uyBC3L54I8ZJgHzyw9njIMbN93poEBv/LNRZTKbzCzT1RSig7SUhpK4ew/JifH7kkOQQ4SgUKgIfQ5Ev2A0u0ALSDQ7olsYzSbQfBLNhuhmRrMKNJdEsyL6OaOBAs0m0UBEP2M0i0AzSzQLopsYzSwHuUQzI7qO0QCB/iKS65bjXxCr2M1VFBBVlJVnVwDRXYzmF2gZieZHdCej+QTqkmg+RHcwmlegpSSaF9GvGM0j0JISzYPodkZzC7S4RHMjuo3RXAItKtFciG5lNKdAi4SmO/4lsIrDXEVxUUVVeXbFET3EaDGBVpFoMUQPMlpUoJUlWhTRA4wGCbSSRIMQ3c9oEYFWlGgRRPcxWligFSRaGNG9jBYSaHmJFkJ0D6MFBVou/fEvh1Wc4irKiirqyLMri+hJRsukRafXlmgZRE8w6hK1KqgL0eOMlhZoLYmWRvQYo6UEWlOipRA9ymiwQGtINBjRI4yWFGh1iZZE9GtGSwi0mkBzpDZsCplt5kdzzhwyG8zbZoVZbOaYe81YE2f6mM6mhaljypsgk4P+pCt0ivbRFlpLb9BztIBmOvAoiqEoa7hUuoV1AliHOArrGJeOBIP4uiSIwyVAHCoO4mAxEAeKgtgfBGIfLI9c2lsYxJ5CIHYXBLGrAIid+UHsyAfiq7wgtuOqyzZccdmaC8SXOUF8kQPEluwgNmcD8XlWEJ8FgtiUBcS6zCA+DQDxSaacAYHZ+V46h1nujM4eZGqbH8xZU84UMdnpD7pMJ2kvbaY19Do9S/PpQZpMCTSYephFZra5x4wxsaa36WSam4Nmq1lv3nI+RonrD/VAfF8XxHd1QFypDeJyLRCemiAu1QBxsTqIb6uB+KYqiAtVQJyvDOJcJRBnK4I4UwHE6fIgTpUDcdwF4vemIH5rAuLXEBC/NAbxcyMQVxuC+KkBiB+967j1b3cVDj7gj2YgTpYFcaLMLc//1XCK+ZanmKpiimkgZ6eqiH7DaBUx/9eXaBVELzBaWdSqoJURPc9oJVFrPYlWQvQcoxVFrQpaEdGzjFYQtdaVaAVEzzBaXtSqoOURPc1oOVFrHfX6n9UJeJr4/z9fIXXx7L7ns6sjzq6xbFgdRL9jtLboEwWtjegVRmuJWhtJtBailxmtKWpV0JqIehitIWptKNEaiF5itLqoVUGrI3qR0WqiVpmc3me4jDW9O7fp3lGQEfk7t+m5U9dvGxKN8Ra3PKXXxwnnR55w6okJJ0RMOLOpXupqbiLfIjJcV0x0Es4YB//PpnsX4W75/q8ZRvwPDlpTEfHm8urUFNHfGW0i4q2gTRD9jdEQUWsziYYg+iujjUWtCtoY0V8YbSRqbSrRRoj+zGhDUauCNkT0KqMNRK1NJNoA0Z8YrS9qbZL+9Z+2UIUnM1fRJm0VG0Ll2bVBNIDR1qJhCtoa0UyMtkqLhipoK0QNo6GiTxQ0FFFitKU44ZYSbYmR+JvRFqJWBW2B6F+MNhe1tpBoc0T/ZLSZqFWiOcx6KuV9/vc+y3vXAJwneecZ/+brAP5VgLPX1gCUJ09P4Z4gCkWBKNgDRIFIEPm7g8jXDUTeriDyRIDI3QVErnAQOTuDyNEJRPaOILJ1AJG1PYjAdiCyhIGgUHiS/rsliL9awNuK9wNRrC+Ion1ABPUGUaQXiMxtQQS0AZGp9W0vtXlK9AdhWt1y/odjTuTiIdZZ5H9rOTo7I5qT0U5iYCtoJ0RzMNpR5L+CdkQ0O6MdRE4oaAdEszHaXrS1lUTbI5qV0XairQraDtFARsNEWxU0DNEsjLYVbW2V/vk/CqsoxFX0EH3SVp5dD0QLMhop+kRBIxEtwGh30ScK2h3R/Ix2E32ioN0QzcdoV9HWNhLtimheRiNEWxU0AtE8jHYRbVXQLojmZjRctLVN+uM/AKsoyVX0F33STp5df0RLMNpP9ImC9kO0OKN9RZ8oaF9EizHaR/SJgvZBtCijvUVbwyTaG9EgRnuJtipoL0SLMNpTtFVBeyJamNEo0daw9Mc/Fqsoz1UMFX3SQZ7dUETLMTpE9ImCDkG0LKMxok8UNAbRMowOFn2ioIMRdTEaLdraXqLRiJZmdJBoq4IOQrQUowNFWxV0IKLBjA4QbW2vrf+VzFjTuXOb7h0FGZG/c5ue6v/yPtq2TNfPdmbXjfOu5j0R5Zt7KvDcEyvmno4Zq3n/sHHg/RWRa7//MSHA+wxP9137Sb7z/B9jokx708TUMC5T0ATSr3SRjtEu2kQf0ErnDmFe6vP/KO/vDNAEGuFcpbqlWkLN7T+QNpkMonQ0iPrJIOolgag7FkSdMSBqJ4KoNRpEzVEgaiSAqD4SRLW7QVQdAaJKPIjKd4GoNBxExWEgKsSBKB8LotEEuxsajgfRYByIckNBlB0CokwMCNdgEKUGgQgeCCJkEojGE2/5/i8BbzFqcJqPFGneWd6djES0OqN3i9upThK9G9FqjI4Qt1MKOgLRqozGi9spBY1HtAqjd4m2KuhdiFZmdLhoq5wNQ4YjWonRYaKtCjoM0YqMxom2dkz//f84rKIBV5Es+qSLPLtkROszmiT6JFyiSYjWY3Ss6BMFHYtoXUbHiD5R0DGI1mE0UbRVQRMRrc3oaNFWJU1GI1qL0VGirQo6CtGajCaItnZOf/ynYRXNuYqpok+6yrObimgzRqeIPomQ6BREmzI6WfSJgk5GtAmjk0SfKOgkREMYnSjaqqATEW3M6ATRViVNJiDaiNHxoq0KOh7RhoyOE23tcoP4l70W/whTgPbREudxtSxE3o3GBE8Yf/p94sS6yRNzozPB05bZGWnZwRqLbiNPG2ZTRKs0Fu1GntbMutOyLo01yLZidroIv8YSsqHM3ivir6TJvYi2ZPQe0c0Keg+iLRidJnqqq/r7vyW9afwCLaRZzv3cGbPfbDFrzGvmGTPPzDDjzHDT13Q2zU0tU8a5F8xCP9MFOkzbaD296YCjaDBFenoSpXqTfR6AW/zbE343c29aCLclLe4B0XwaiGZTAepFT4DqSQtARdF8UD3ocVCR9Bio7jQPVDeaC6orPQoqgh4B1YUeBhVOc0B1ptmgOtEsUB3pIVAdaCao9vQgqHb0AKgwuh9UW7oPVBuaAao1pYBqRW5QoTQdurOlL/9dZDaamSbc5KM9tIgGpP6GvS/70ZbiNNo3tuaIYdldyQb0pThd5GNni+zXWDScOR3qY2eJMa2x6Dhzut/HPiSyX2PRcuYEy8fOFNmvseg5c0LrYx9Myx7XZg40nTkDwcc+IGYOjUXXmTNsfOz9adll3W4w//+3+KMtxUky32fPF/GPVM4LfSlOSvrYx0X8NRYNZ04C+9jHRPw1Fh1nTrr72Hki/hqLljNncvCxc0X8NRY9Z85U4mMfFfHXxg6azpyJx8c+IuKvseg6c6YpH/uwiH/3G8S/hjf+C5x5PphO0HLnIUl3Aoe40aPiGcgVPSUGQw/lJNGk4hnA7JNiMGgsus88/ZldIgaDxqL9zNOP2cViMGgs+s88fZldJAaDxqIBzdOH2YViMMiBNDvWHeRdVlvY+Prl0Uc/oVieK4W40XXmXBZ9b14g4h+prf9X3hCZsTR3p65Oe40YGYvzd27TvemeEfl/QdPTac65+f0f2pI8cXxteUFc8qOUSyD6kjyxzD4vLvkai4Zjz1BmnxOXfI1Fx7FnCLPPiku+xqLl2BPD7DJx4dVY9Bx7BjP7jLjka7cLaDr2RDO7VNz/aSy6jj2DmH1aXP973OD5fyKZ781ps8+sNq+apaaTaWZqGpcpYDLTVTpPh2grraNVTufPdx5IJpq5JsUkm2Gmj9lMI5zREgED6vaf/UfR66AS6DVQI+lVUHfTSlAj6BVQ8fQyqLvoJVDD6UVQw2gFqDhaDiqWXgA1lJ4HNYSeAxVDz4IaTMtARdMzoJLobVBj6S1QY+hNUIm0CtRoegPUIFoKaiA9DWoAPQUqmd4B1Z+eBNWPloDqS4tvnv9oS3Oi4xtbr4r876mMS/SlObH0sStF/mssGk6dyPvYV0T+ayw6Tp1x4mNfFvmvsWg5dUaVj31J5L/GoufUGYM+9kWR/9rcgaZTZ8T62BUi/zUWXafO+Paxy0X+R6Xj+R+9BZ5x/NnviPj3Us4LbULOuPSxb4v4a2w9ZJOYfUvEX2PRcepknI99U8RfY9Fy6uSnj10l4q+x6Dl1stnHviHir40dNJ06ue9jXxfx11h0nTrzqY99TcS/Zzrij94CzzT+7LUi/r2V80LTkGcqs2tE/DUWXUOeKcyuFvHXWLQNeSYz+6GIv8aib8gzidkPRPw1Fo1DnonMvi/ir40ddA55JjD7noi/xqJ1yDOe2XdF/Hv9E6//s+lLULPoC1AP0RZQM2kzqAfpc1AP0Geg7qdNoO6jjaBm0KegUugTUG76GNR02gDqXloP6h5aB2oafQRqKq0FNZd2gHqUvgL1CG0H9TBtAzWHtoKaQmtATabVoCbRh6Dm0U5QE+kDUBPofVDj6b2b57/lLbifx9ZGkf99lHFpmcbuY/ZTkf8aa7nGZjD7ich/jbVsYynMfizyX2Mt35ib2Q0i/zXWMo5NZ3a9yH9t7kDnmDPWfOw6kf8ai9YxZ2T62I9E/vf+b+u/3vjfbP3XMho8zBVtFYOhr3KSloNoDrNfisGgsZaFaDazX4jBoLGWh2gWs1vEYJDsnCLujt512EUlr09HPnqzsg5bN8RtGYdm8ps/F/HXxo7lHHqQ2c9E/DXWsg49wOwmEf8+2vpvPeqbsf57B6//1s9Y/81Y/82I/B3X9Ftc/7W8ZQv42rJHXPL7KdclyzQ6n9nd4pKvsZZr9HFmd4lLvsZattHHmN0pLvkaa/lG5zG7Q1zwNdYyjs5l9itx/dduUyzn6KPMbhfXf421rKOPMLtNXP/7puP53/KWPc2f/bWIf3/lvCzT6FPMHhbx11jLNfoks4dE/DXWso0uYfagiL/GWr7RxcweEPHXWMs4uojZ/SL+2tixnKMLmd0n4q+xlnX0CWb3ivj3U5//g52H+PQ//zv/X3/+d76vegtP/G/QZVAv0XlQL9I5UCvoLKjldAbUC3Qa1PN0CtRzdBLUs3QC1DI6DuoZOgZqKR0F9TQdAfUUfQ3qSToMagkdArWYDoJ6jS6BepUuglpJ34J6hb4B9TJdALWIDoBaSPtBPUH7QL1OHlALaC+o+bQH1OO0++b5H4djazmPrdMi/wco49IyDb/A7CmR/xpruYafZ/akyH+NtWzDzzF7QuS/xlq+4WeZPS7yX2Mt4/AyZo+J/NfmDss5/AyzR0X+a6xlHV7K7BGR//3TMf9bxp/X+LMvivgPVM7Lcv68yuy3Iv4aa1l/VjL7jYi/xlren1eYvSDir7GW+edlZs+L+Gus5f55idlzIv7a2LHsPy8ye1bEX2Mt/88KZs+I+A9IR/wt48+7/Nk/ivgPUs7Lcv68w+wPIv4aa1l/3mb2exF/jbW8P28x+52Iv8Za5p83mb0i4q+xlvtnFbOXRfy1sWPZf95g1iPir7GW/+d1Zi+J+A+8wd9/bYbxn5j6h6Nu5a8Aui1nz1qu93cR32i5tNbBPcW7tLaYfPQapn8TEY6+jeUp71/MCnFb3p/V/Mm/ivhHK31pmX8+ZPYXEX+Ntdw/HzD7s4i/NnYs+8/7zF4V8ddYy//zHrM/ifgPuvHPf/aZzbd99+e9Z0z97n/6+c8mkwXURpMZ1KcmANQnJhOoj40BtcHgZ66nv0Gto79AfUR/glpLf4BaQ7+DWk2/gfqQfgX1Af0C6n36GdR7dBXUFyYHqC0mO6jNJhuoz01WUJ+ZQFDv0k+g3qEfQb1NP4B6i74H9SZ9B2qryQXqS+PdIqRFxvLOndt0758izIj8ndt071ycEfk7t+k3vf9PsRy8G6/vLWbS3FvUHizvS1IsB69/v8C0rEtjLQevf8PAtGw+jbUcvP79AtOypLGWg3cDs3+Lezjt/s+y8K5n9i9xD6exlof3+h5uf4p7OI21zPkfMfuHeEaLvv3nvxTLw+nfWyxtX67S+tLycPo3DUzLLtNYy8Pp3zUwLTtXYy0Pp3/bwLTsdI21PJz+fQPTsokaa3k4/RsHpmUHa6zl4fTvHJiW7aaxlkPfv3VgWjZ0cDrib3k4/XuLifyPUc7L8nD6Nw0U+a+xlofTv2ugyH+NtTyc/m0DRf5rrOXh9O8bmJa9osXB8nD6Nw5Myx7XWMvD6d85MC27Q2Mtj7Z/68C07IbB6vNfaYogeKq7yfPftd/48/28wPfMqDzVnTEVQJ025UGdMriT+UlTFtQJUwbUceMCdcyUBnXUlAJ1xASD+tqUBHXYlAB1yBQHddAUA3XAFAW13wSB2meKgNprCoPaYwqB2m0KgtplCoDaafKD2mHygfrK5AW13eQBddFUB/Wtwd3hvzFVQV0wVUCdN5VBnTOVQJ01FW+e/5Zt17+3nJj/tVyybLv+TSPF/K+xlm3Xv2ukmP811rLt+reNFPO/xlq2Xf++kWL+11jcONLj3zhSzP8aa3l4/TtHivlfYy2Pvn/rSDH/x6Rj/rc8XP69pcT8P0Q5L8vD5d80Usz/Gmt5uPy7Ror5X2MtD5d/20gx/2us5eHy7xsp5n8tDpaHy79xpJj/NdbycPl3jhTzv8Zatnz/1pFi/k9P/C0Pj39vKZH/Wl9aHh7/pnEi/zXW8vD4d40T+a+xlofHv22cyH+NtTw8/n3jRP5rrOXh8W8cJ/JfYy0Pj3/nOJH/Gmt5NP1bx4n8l+x/APqInDwAjAAA";
/// 1536 bytes.
pub(crate) const WAL_DB3: &str = "H4sIAAAAAAACA+2Tv07DMBDGzymoU6YOVYZKN1IpIgMvQIIsFBHSkgaJTpFJTGSp+aPYDGHLKzLyNCQtgRSE2BigP1nn83e29Ulnr248oTg+FFXGFJ6BBpoG54gAbQowgg+69dFgTeBnNDiNib5NXoCUbfg1mok2ns5mpKkVu9/wjEvJUi77eXQRUDukGNqOR7FXT0SCrh/SSxrgMnCv7WCNV3RtqqIUcTQo+osQ/VvPM5VozyqWlV9LmDDF0PEWzrs2b3QynhoGaR63rrb3yl3U9hzttO/85CzjGNK7cGCkLj9LkleCbcQTU6LIo7ce722Zd70h5BnaceBPYJJjMNyJVRYiVykvMq6qOspkKq02WMtOXnUPlidxUun9zz7wL3kF+zaxnQAGAAA=";
/// 3784 bytes.
pub(crate) const WAL_LOG: &str = "H4sIAAAAAAACA+3WS0wTQRgH8JntGyggIFCgMEDLQ8FXD15MBExjjBUVq8FEY1ap2mil0nrAi6KeNBqNifHgwasnD8aLF40mxkBivHjQgxqNxjfFBz7wtduvH1b+NXLyYPwOs92Z/e03nfl2swv32Q+I9oeVQmjCCLlx+w3L8JFLG++c3BFPNd+8b/aZA9x//cruzZ4Tp1esWR2KJiNqa/9ATE+qgKE1TXQoJehGTvEzzHNr1rkUfw5NzNki3ekfd4WMG81fi6FSzVHh9cqhwaS+eWckFkkk9G2RBB8tS3qCneGgCnd2hYKKe1uifWpZdzi4NNijVvUsW9HZs14tD65vS/bHo1s2ZQ12rwyr7rWhUFsyatikHovjkOrTk7rqCq3smuxrHXJLR4XHI4f2pGeVvm+CWu2XGVHf7+azS49FVDjYG86ayGB8alciMhDVd0b36slo/65NmT3+5ZJWY6Es2XXhHbl2wb/h/XGbudnypTnklBNyXI7Ryf/4J8PhMxp7tdHYSsydd/GzznVx8MnhM5/Ojd0yn2WXaBRyRJ6SumwTH8RVcVT0Gl0cAZdNuLQ+S8p8QzgyLxHzZjE9nrmkuIOOqcuZ476Ak9AoIwegAkQOQq8Z2QE5EdkJvWJkA2RFZCP0kpEVkEBkJfSCkQXQx8WALISeM9IApRBphJ4xkoAeIJKEnjIS+J/EVJRZr8m6mO27eE6sOzQxnboooXyfON8MyFePaziD0EdGxYAUomJCHxgVAapFVERonFEhoBpEhYTeM3IDqkLkJvSOUQGgSkQFhN4yygdUjiif0BtGeYDKEOURGmPkAlTSkaMu7Nl1MXx+0RvlH789nbqoTuezapyvCvLNwklWEZKMPIBaEXkICUaVgFoQVdJyfGdUAagZUQWhb4zKATUhKif0ldFMQH5EMwl9YVQGyIeojNAEo1JAjYhKCX1mVAKoIVddOLLr4t6x0SWPH51tn05d+Gi38jlf49R8++fjJBsJ5TFqgEnmQA2EXIzqIdM8RPWEnIwUZMqBFCEHozpAcxHVEbIzqgU0B1EtIRsjL6B2RF5CVkY1gNoQ1RCyMKoGNDtXXZifBU6uCz2w/d3VWanH6fenUQ6TdfE/fhuBFlr4Il74ZijbAO5WM6FCRk2wWzlQEyE3Iz9kWoDIT6iAkQ8yIfoB6UoWA8gOAAA=";

pub(crate) fn bytes(text: &str) -> Vec<u8> {
    let packed = base64::engine::general_purpose::STANDARD.decode(text).unwrap();
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(packed.as_slice()).read_to_end(&mut bytes).unwrap();
    bytes
}
